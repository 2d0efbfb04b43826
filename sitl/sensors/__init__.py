"""What the vehicle senses: the camera and the state estimate."""
