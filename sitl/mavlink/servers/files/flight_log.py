"""Keep a tlog of each flight in the vehicle's folder: from arming to disarming, all links."""

import logging
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from sitl.errors import UsageError
from sitl.mavlink.wire.tlog import TlogWriter

MAX_FLIGHTS = 100  # of one run; whoever arms on and on must not fill the disk
MAX_BYTES = 256 << 20  # of one flight: about two hours

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogFile:
    """A finished log."""

    path: Path
    started_unix_s: int
    size: int


class FlightLog:
    """Follow the vehicle's arming; give the finished logs, the oldest first."""

    def __init__(
        self, folder: Path | None, *, unix_epoch_us: int, clock: Callable[[], int]
    ) -> None:
        """Write to `folder` (None: write nothing); `clock` gives vehicle time in us."""
        self._folder = folder
        self._unix_epoch_us = unix_epoch_us
        self._clock = clock
        self._writer: TlogWriter | None = None
        self._path = Path()
        self._started_unix_s = 0
        self._bytes = 0
        self._flights = 0
        self.finished: list[LogFile] = []

    def record(self, *packets: bytes, link: int) -> None:
        """Keep packets of one moment, if there is a flight."""
        if self._writer is not None and self._bytes < MAX_BYTES:
            self._bytes += sum(map(len, packets))
            self._writer.record(*packets, link=link)

    def follow(self, *, armed: bool) -> None:
        """Begin or end a flight's log."""
        if armed and self._writer is None:
            if self._folder is not None and self._flights < MAX_FLIGHTS:
                self._begin(self._folder)
        elif not armed and self._writer is not None:
            self._end(self._writer)

    def flush(self) -> None:
        """Hand what is buffered to the system."""
        if self._writer is not None:
            self._writer.flush()

    def close(self) -> None:
        """End the last flight's log."""
        if self._writer is not None:
            self._end(self._writer)

    def _begin(self, folder: Path) -> None:
        self._flights += 1
        self._bytes = 0
        self._started_unix_s = (self._unix_epoch_us + self._clock()) // 1_000_000
        self._path = folder / f"{self._started_unix_s}-{self._flights:03d}.tlog"
        try:
            self._writer = TlogWriter(
                self._path,
                unix_epoch_us=self._unix_epoch_us,
                clock=self._clock,
                option="--files",
            )
        except UsageError as error:
            self._flights = MAX_FLIGHTS
            _log.warning("no log of this flight: %s", error)

    def _end(self, writer: TlogWriter) -> None:
        writer.close()
        self._writer = None
        self.finished.append(
            LogFile(
                path=self._path,
                started_unix_s=self._started_unix_s,
                size=self._path.stat().st_size if self._path.exists() else 0,
            )
        )
