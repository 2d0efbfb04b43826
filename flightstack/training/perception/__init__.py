"""Training of perception."""
