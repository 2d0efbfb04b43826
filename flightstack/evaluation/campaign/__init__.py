"""Fly many trials: workers, folder, progress, interruption."""
