"""A film of a flight: what the camera saw, what was decided, where it was."""
