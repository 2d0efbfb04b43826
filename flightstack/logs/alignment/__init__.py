"""Two logs of one flight on one axis of time."""
