"""One server for each MAVLink protocol service."""
