"""The networks as they are trained, in torch: what flies is their flight form, exported here."""
