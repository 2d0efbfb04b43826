"""Trials: what is asked for, flown in parallel into a folder that resumes."""
