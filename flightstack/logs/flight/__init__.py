"""What happened: vehicle, modes, motion, course, decisions."""
