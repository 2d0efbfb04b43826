"""The autopilot: parameters, modes and failsafes, control cascade, mixer."""
