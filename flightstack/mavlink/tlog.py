"""Write a tlog: every packet of both directions, each after its time.

A record is a big-endian 64-bit count of microseconds since 1970, then the packet as it was on the
wire. Times are the wall time of the start plus the vehicle time since, so that rates in the log
read right at any simulation speed. Only whole records reach the file, in one write each second:
after a crash of the process the file ends at a record's end. A long flight goes on in more files,
flight.1.tlog after flight.tlog, each a log of its own.
"""

import os
import struct
import time
from collections.abc import Callable
from pathlib import Path

from flightstack.errors import UsageError
from flightstack.mavlink_numbers import LINK_BITS

FLUSH_S = 0.5  # wall time
FLUSH_BYTES = 1 << 16
MAX_BYTES = 256 << 20  # of one file: some three hours at 400 messages a second
TIME = struct.Struct(">Q")


class TlogWriter:
    """A log; when the disk refuses, `failure` says why and nothing more is written."""

    def __init__(
        self,
        path: Path,
        wall_s: Callable[[], float] = time.monotonic,
        *,
        max_bytes: int = MAX_BYTES,
    ) -> None:
        self.path = path  # of the first file
        self._current = path
        self._parts = 1
        self._max_bytes = max_bytes
        self.failure: str | None = None
        self._wall_s = wall_s
        self._start_us = time.time_ns() // 1000
        self._pending = bytearray()
        self._written = 0  # bytes of whole records in the file
        self._flushed_s = wall_s()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = _create(path)
        except OSError as error:
            raise UsageError(
                f"cannot write the log {path}: {error.strerror}; choose another --log"
            ) from error

    def append(self, elapsed_us: int, packet: bytes) -> None:
        """Add a packet at a vehicle time counted from the start of the log."""
        time_us = self._start_us + elapsed_us & ~LINK_BITS
        self._pending += TIME.pack(time_us) + packet
        if len(self._pending) >= FLUSH_BYTES:
            self.flush()

    def flush_if_due(self) -> None:
        """Write what is pending if the last write is half a second (wall time) old."""
        if self._wall_s() - self._flushed_s >= FLUSH_S:
            self.flush()

    def flush(self) -> None:
        """Write what is pending; on failure keep the file at its last whole record."""
        self._flushed_s = self._wall_s()
        pending = bytes(self._pending)
        self._pending.clear()
        if self.failure is not None or not pending:
            return
        try:
            written = 0
            while written < len(pending):
                written += os.write(self._file, pending[written:])
        except OSError as error:
            self.failure = f"the log {self._current} ends here: {error.strerror}"
            self._cut_back()
            return
        self._written += len(pending)
        if self._written >= self._max_bytes:
            self._go_on_in_next_file()

    def close(self) -> None:
        """Write what is pending and close; a log that holds nothing is removed."""
        if self._file < 0:
            return
        self.flush()
        os.close(self._file)
        self._file = -1
        if self._written == 0 and self.failure is None:
            self._current.unlink(missing_ok=True)

    def _go_on_in_next_file(self) -> None:
        path = self.path.with_suffix(f".{self._parts}{self.path.suffix}")
        try:
            file = _create(path)
        except OSError as error:
            self.failure = f"the log {self._current} ends here: {path}: {error.strerror}"
            return
        os.close(self._file)
        self._file, self._current, self._written = file, path, 0
        self._parts += 1

    def _cut_back(self) -> None:
        try:
            os.ftruncate(self._file, self._written)
        except OSError:  # a device, not a file: there is nothing to cut
            return


def _create(path: Path) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644)
