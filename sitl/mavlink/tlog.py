"""Write the traffic of all links as a tlog, which ground stations and MAVLink tools read.

A record is the time (big-endian, microseconds since 1970) and the raw frame. The two low bits of
the time are the link's number, where pymavlink looks for it. Times are the wall clock at the
start plus vehicle time, so that rates read right at any speed.
"""

import struct
from collections.abc import Callable
from pathlib import Path

from sitl.errors import UsageError

TIME = struct.Struct(">Q")
LINK_BITS = 0b11
BUFFER_BYTES = 1 << 16


class TlogWriter:
    """One file; `flush` is the caller's duty, at least once a second."""

    def __init__(self, path: Path, *, unix_epoch_us: int, clock: Callable[[], int]) -> None:
        """Create the file; `clock` gives vehicle time in us.

        Raises:
            UsageError: the file cannot be written.

        """
        try:
            self._file = path.open("wb", buffering=BUFFER_BYTES)
        except OSError as error:
            raise UsageError(f"--log {path}: {error.strerror}") from None
        self._unix_epoch_us = unix_epoch_us
        self.clock = clock

    def record(self, raw: bytes, *, link: int) -> None:
        """Append one frame, sent or received."""
        time_us = (self._unix_epoch_us + self.clock()) & ~LINK_BITS | link & LINK_BITS
        self._file.write(TIME.pack(time_us) + raw)

    def flush(self) -> None:
        """Hand what is buffered to the system."""
        self._file.flush()

    def close(self) -> None:
        """Flush and close."""
        self._file.close()
