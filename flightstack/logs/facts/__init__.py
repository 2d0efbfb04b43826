"""What a log says as plain values, ready for JSON."""
