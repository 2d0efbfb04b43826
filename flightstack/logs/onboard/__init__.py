"""The vehicle's own logs, PX4's ULog and ArduPilot's DataFlash, as topics and MAVLink messages."""
