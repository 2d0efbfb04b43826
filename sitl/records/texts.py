"""A line of text for the pilot."""

from dataclasses import dataclass

CRITICAL, WARNING, NOTICE, INFO = 2, 4, 5, 6  # MAV_SEVERITY of a StatusText


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusText:
    """A line for the pilot, with its MAV_SEVERITY."""

    severity: int
    text: str
