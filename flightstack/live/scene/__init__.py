"""What is drawn of a piece of a flight, on one axis of vehicle time."""
