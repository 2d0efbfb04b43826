"""The front camera: what it sees, how the world looks, what spoils an image."""
