"""Look at a flight in a browser while it is flown, or afterwards."""
