"""Sleep until one of several things can be read."""

import select
from typing import Protocol


class Readable(Protocol):
    """Something that a selector can wait on."""

    def fileno(self) -> int:
        """Return the descriptor."""


def wait_for_any(timeout_s: float, *sources: Readable) -> bool:
    """Sleep until a source has something, `timeout_s` of wall time at most; say whether one has."""
    ready, _, _ = select.select(sources, [], [], timeout_s)
    return bool(ready)
