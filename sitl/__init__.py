"""A simulated PX4-style vehicle: pybullet physics, an autopilot, a camera, MAVLink 2 over UDP."""
