"""From bytes to packets to columns."""
