"""Checks of a flight, each with a name, a level and a reason; users can add their own.

>>> from flightstack.logs.checks import Level, check
>>> @check("too_high", title="Height", meaning="Above 100 m you need a licence.")
... def too_high(flight):
...     height = -flight.motion.position_ned[:, 2].min()
...     return Level.WARNING if height > 100 else Level.OK, f"at most {height:.0f} m"
"""

from flightstack.logs.checks import log_health, motion_health, offboard_health, onboard_health
from flightstack.logs.checks.registry import (
    Check,
    Finding,
    Level,
    check,
    graded,
    load_checks,
    run_checks,
)

__all__ = [
    "Check",
    "Finding",
    "Level",
    "check",
    "graded",
    "load_checks",
    "log_health",
    "motion_health",
    "offboard_health",
    "onboard_health",
    "run_checks",
]
