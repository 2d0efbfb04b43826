"""Decision: N x M Gaussians over each velocity to one command. Pure numpy."""
