"""Policy: latent samples to N x M Gaussians over the velocities."""
