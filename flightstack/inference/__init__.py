"""Inference: networks in their flight form, run."""
