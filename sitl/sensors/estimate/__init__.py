"""The state estimate and its errors."""
