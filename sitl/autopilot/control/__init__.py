"""The control cascade: position, attitude, rates, motors."""
