"""From training runs to the models that are published."""
