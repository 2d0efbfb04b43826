"""Say which part of a pilot failed, and why, in one line."""

import mmap
from dataclasses import dataclass

PARTS = ("pilot", "perception", "policy", "strategy")  # the whole, then as they work
PERCEPTION, POLICY, STRATEGY = 1, 2, 3


@dataclass(frozen=True, slots=True, kw_only=True)
class PartFailure:
    """A part of the pilot gave nothing that can be flown by."""

    part: str  # one of PARTS
    reason: str

    def __str__(self) -> str:
        return f"{self.part} {self.reason}"


class PartError(Exception):
    """A part gave something that the next one cannot work with; the text says what."""


class PartMarker:
    """Which part is at work; a process that is forked later marks for its parent, too."""

    def __init__(self) -> None:
        self._shared = mmap.mmap(-1, 1)

    @property
    def part(self) -> str:
        """The part that began last."""
        return PARTS[self._shared[0]]

    def mark(self, index: int) -> None:
        """Note that this one of PARTS begins."""
        self._shared[0] = index


def explain(error: BaseException) -> str:
    """Say what a part raised, or gave."""
    if isinstance(error, PartError):
        return str(error)
    words = (str(error).splitlines() or [""])[0]
    return f"raised {type(error).__name__}" + (f": {words}" if words else "")
