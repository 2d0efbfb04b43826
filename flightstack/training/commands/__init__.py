"""The commands of `python -m flightstack.training`."""
