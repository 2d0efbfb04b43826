"""What each flight mode wants: setpoints of take-off, mission, return, sticks, offboard."""
