"""What the command lines of all rooms have in common."""
