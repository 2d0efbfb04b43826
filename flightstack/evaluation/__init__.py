"""Evaluation: judge models offline, and draw what they say. Needs the extra `evaluation`."""
