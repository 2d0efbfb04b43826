"""Training: the expert's data, the perception and the policies, and the model folders."""
