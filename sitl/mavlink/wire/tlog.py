"""Write the traffic of all links as a tlog, which ground stations and MAVLink tools read.

A record is the time (big-endian, microseconds since 1970) and the raw packet. The two low bits of
the time are the link's number, where pymavlink looks for it. Times are the wall clock at the
start plus vehicle time, so that rates read right at any speed. A long flight goes on in further
files, flight.1.tlog after flight.tlog, each a log of its own.
"""

import logging
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from sitl.errors import UsageError

TIME = struct.Struct(">Q")
LINK_BITS = 0b11
BUFFER_BYTES = 1 << 16
MAX_BYTES = 256 << 20  # of one file: some hour and a half of both links

_log = logging.getLogger(__name__)


class TlogWriter:
    """A log; `flush` is the caller's duty, at least once a second.

    When the file cannot be written any more (a full disk), this is reported once, the file ends
    with the last whole buffer, and the flight goes on unrecorded.
    """

    def __init__(
        self,
        path: Path,
        *,
        unix_epoch_us: int,
        clock: Callable[[], int],
        max_bytes: int = MAX_BYTES,
        option: str = "--log",
    ) -> None:
        """Create the file; `clock` gives vehicle time in us, `option` is what asked for it.

        Raises:
            UsageError: the file cannot be written.

        """
        try:
            self._file = path.open("wb", buffering=0)
        except OSError as error:
            raise UsageError(f"{option} {path}: {error.strerror}") from None
        self._path = path  # of the first file
        self._parts = 1
        self._max_bytes = max_bytes
        self._unix_epoch_us = unix_epoch_us
        self._buffer = bytearray()
        self._written = 0  # bytes, all whole records
        self._failed = False
        self.clock = clock

    def record(self, *packets: bytes, link: int) -> None:
        """Append packets of one moment, sent or received."""
        if self._failed:
            return
        time_us = (self._unix_epoch_us + self.clock()) & ~LINK_BITS | link & LINK_BITS
        self._buffer += TIME.pack(time_us).join((b"", *packets))
        if len(self._buffer) >= BUFFER_BYTES:
            self.flush()

    def flush(self) -> None:
        """Hand what is buffered to the system."""
        buffer, self._buffer = memoryview(self._buffer), bytearray()
        if self._failed or not buffer:
            return
        try:
            rest = buffer
            while rest:
                rest = rest[self._file.write(rest) :]
            self._written += len(buffer)
            if self._written >= self._max_bytes:
                self._go_on_in_next_file()
        except OSError as error:
            self._give_up(error)

    def close(self) -> None:
        """Flush and close."""
        self.flush()
        self._file.close()

    def _go_on_in_next_file(self) -> None:
        path = self._path.with_suffix(f".{self._parts}{self._path.suffix}")
        file = path.open("wb", buffering=0)
        self._file.close()
        self._file, self._written = file, 0
        self._parts += 1

    def _give_up(self, error: OSError) -> None:
        self._failed = True
        _log.warning("log %s ends here: %s; the flight goes on", self._path, error.strerror)
        with suppress(OSError):  # a pipe or a device has no end to cut
            self._file.truncate(self._written)
