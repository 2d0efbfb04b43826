"""The components beside the autopilot: camera and referee."""
