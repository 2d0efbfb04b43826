"""Ready to fly? All that can be tried without moving the vehicle: `--check`."""
