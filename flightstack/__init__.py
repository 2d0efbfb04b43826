"""Uncertainty-aware navigation for MAVLink vehicles: perception, policy, decision, companion."""

__version__ = "0.1.0"
