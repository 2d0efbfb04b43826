"""Bytes and messages: dialect, packets, signing, the telemetry log."""
