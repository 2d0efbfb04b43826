"""Rows of trials that nobody flew."""

from dataclasses import fields
from typing import Any

from flightstack.evaluation.rows import TrialRow


def made_row(**given: Any) -> TrialRow:
    """Make a row of zeros and empty texts, but for what is given."""
    values: dict[str, Any] = {
        field.name: 0.0 if field.type == "float" or field.type is float else ""
        for field in fields(TrialRow)
    }
    values |= {"gates_total": 32, "gates_passed": 0, "track_seed": 0, "trial": 0, "seed": 0}
    values |= {"retries": 0, "failed_gate": None, "command_factor": 1.0, "model": "strong/m0"}
    return TrialRow(**(values | given))
