"""Perception: image bytes to samples of the latent posterior."""
