"""A vehicle that another simulator moves: our camera and referee at the pose that it tells."""
