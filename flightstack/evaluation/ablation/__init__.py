"""Ablation: which part of a strategy makes its effect, beside controls that fly as fast."""
