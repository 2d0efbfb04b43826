"""A real PX4 as the flight controller: its simulator interface, and a relay of its companion."""
