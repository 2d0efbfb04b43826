"""What a user may ask of the vehicle on the command line and in files."""
