"""Bytes and messages: dialect, framing, signing, the telemetry log."""
