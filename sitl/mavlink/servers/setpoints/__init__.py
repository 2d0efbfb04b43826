"""Setpoints and sticks, as the autopilot takes them."""
