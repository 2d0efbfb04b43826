"""The companion process: where camera, MAVLink, perception, policy and decision meet."""
