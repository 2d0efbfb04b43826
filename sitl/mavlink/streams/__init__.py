"""Telemetry: which message is encoded by what, and how often it is sent."""
