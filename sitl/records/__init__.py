"""The frozen records that travel between the rooms of the simulator."""
