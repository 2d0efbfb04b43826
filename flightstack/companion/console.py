"""Tell how the flight goes: lines for events, and one live line where there is a terminal.

Much of it others have said. Whatever a terminal would obey is written out.
"""

import sys
import time
from collections.abc import Callable
from typing import TextIO

from flightstack.printable import printable

LIVE_S = 0.2  # wall time between two versions of the live line
ERASE_LINE = "\r\x1b[K"


class Console:
    """Lines on standard error, so that standard output holds the result alone."""

    def __init__(
        self,
        *,
        verbosity: int = 0,
        stream: TextIO | None = None,
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = sys.stderr if stream is None else stream
        self._verbosity = verbosity
        self._is_live = verbosity >= 0 and self._stream.isatty()
        self._wall_s = wall_s
        self._live_s = 0.0
        self._live = ""

    def event(self, text: str) -> None:
        """Tell what everybody wants to know, unless told to be quiet."""
        if self._verbosity >= 0:
            self._write_line(text)

    def detail(self, text: str) -> None:
        """Tell what matters when something is being looked into."""
        if self._verbosity >= 1:
            self._write_line(text)

    def warning(self, text: str) -> None:
        """Tell what is wrong, however quiet."""
        self._write_line(f"warning: {text}")

    @property
    def wants_live(self) -> bool:
        """Whether it is time for a new version of the live line."""
        return self._is_live and self._wall_s() - self._live_s >= LIVE_S

    def live(self, text: str) -> None:
        """Replace the live line."""
        self._live_s = self._wall_s()
        self._live = printable(text)
        self._stream.write(ERASE_LINE + self._live)
        self._stream.flush()

    def close(self) -> None:
        """Remove the live line."""
        if self._live:
            self._live = ""
            self._stream.write(ERASE_LINE)
            self._stream.flush()

    def _write_line(self, text: str) -> None:
        above = ERASE_LINE if self._live else ""
        self._stream.write(f"{above}{printable(text)}\n{self._live}")
        self._stream.flush()
