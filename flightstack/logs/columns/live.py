"""Read a log that is being written, or a live link: whole packets as they come."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.reading import from_packets
from flightstack.logs.errors import LogFileError
from flightstack.logs.tlog.packets import join
from flightstack.logs.tlog.scanner import scan
from flightstack.logs.tlog.source import MemorySource

MAX_PENDING_BYTES = 1 << 16  # bytes that may wait for the rest of a packet


class PieceReader:
    """Cuts a growing stream of bytes into logs of whole packets."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, data: bytes) -> Log:
        """Return the packets that are now whole."""
        self._pending += data
        source = MemorySource(np.frombuffer(self._pending, dtype=np.uint8))
        log = from_packets(source, join(list(scan(source))))
        used = int(log.packets.end[-1]) if len(log) else 0
        self._pending = self._pending[used:][-MAX_PENDING_BYTES:]
        return log


class GrowingFile:
    """Reads what is appended to a file; starts again when it was cut."""

    def __init__(self, path: Path, *, from_start: bool) -> None:
        self._path = path
        try:
            size = path.stat().st_size
        except OSError as error:
            raise LogFileError(f"{path} cannot be followed: {error.strerror}") from error
        self._position = 0 if from_start else size

    def __call__(self) -> bytes:
        """Return the bytes that came since the last call."""
        try:
            size = self._path.stat().st_size
            if size < self._position:
                self._position = 0
            with self._path.open("rb") as file:
                file.seek(self._position)
                data = file.read(1 << 22)
        except OSError as error:
            raise LogFileError(f"{self._path} cannot be followed: {error.strerror}") from error
        self._position += len(data)
        return data


def connection_string(text: str) -> str:
    """Return a connection as pymavlink writes it: a bare port, udpin:H:P and udpin://H:P."""
    if text.isdigit():
        return f"udpin:0.0.0.0:{text}"
    return text.replace("://", ":", 1)


def open_link(text: str) -> Callable[[], bytes]:
    """Return a reader of a live link; it only listens, it sends nothing."""
    from pymavlink import mavutil  # noqa: PLC0415

    try:
        link = mavutil.mavlink_connection(connection_string(text))
    except (OSError, ValueError, IndexError) as error:
        raise LogFileError(f"{text} cannot be opened: {error}; try udpin:0.0.0.0:14550") from error

    def receive() -> bytes:
        data = link.recv(4096)
        return data if isinstance(data, bytes) else b""

    return receive


def at_times(log: Log, now_us: int) -> Log:
    """Return a live piece, whose packets carry no times, as received now."""
    times: NDArray[np.int64] = np.full(len(log), now_us, dtype=np.int64)
    return Log(log.source, log.packets, times)
