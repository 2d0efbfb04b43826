"""What stands between a pilot and the vehicle: whoever may fail, and what nobody may ask for."""
