"""Which pilot flies, and the one that a user brings whole."""
