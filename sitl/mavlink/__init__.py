"""The MAVLink side of the vehicle: links, streams and protocol servers."""
