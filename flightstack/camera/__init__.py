"""Where images come from: the vehicle's stamped stream, or any camera that OpenCV opens."""
