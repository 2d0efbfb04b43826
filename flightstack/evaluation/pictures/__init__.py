"""Pictures of an experiment, made from its rows and traces alone: one module per picture."""
