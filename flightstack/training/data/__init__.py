"""The data: expert pilot, flights, gate views, data sets."""
