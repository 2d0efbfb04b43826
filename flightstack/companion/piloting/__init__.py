"""Pilots that cannot take the flight with them: what they do wrong comes back as a failure."""
