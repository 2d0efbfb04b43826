"""Read the bytes of a log in windows of bounded size, and say what a file is that is no log."""

import os
from collections.abc import Iterator
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.errors import LogFileError

WINDOW_BYTES = 2 << 20  # fits the caches; larger is not faster
SMALL_BYTES = 32 << 20  # logs up to here are held in memory, larger ones read by windows
MISTAKEN = {  # first bytes of files that people pass by mistake
    b"ULog\x01\x12\x35": "a PX4 ULog, without windows: read it whole, with flightstack.logs.read",
    b"\xa3\x95": "an ArduPilot .bin, without windows: read it whole, with flightstack.logs.read",
    b"\x89MCAP0\r\n": "an MCAP file, not a MAVLink log: open it in Foxglove",
    b"\x1f\x8b": "compressed with gzip: unpack it with gunzip first",
    b"PK\x03\x04": "a ZIP archive: unpack it first",
    b"SQLite format 3": "an SQLite database, not a MAVLink log",
    b"FMT, ": "an ArduPilot text log, not a MAVLink log: use mavlogdump.py or MAVExplorer",
    b"\x7fELF": "a program, not a MAVLink log",
    b"\x89PNG": "a picture, not a MAVLink log",
}


class ByteSource(Protocol):
    """Bytes of a log that can be read at any place."""

    @property
    def name(self) -> str:
        """What to call the log in messages."""

    @property
    def size(self) -> int:
        """Number of bytes."""

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Return the bytes from start to stop, fewer where the log ends."""


class FileSource(NamedTuple):
    """A log in a file; `size` is what it was when the file was opened."""

    name: str  # its path
    size: int

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Return the bytes from start to stop, fewer where the file ends."""
        count = max(0, min(stop, self.size) - start)
        return np.fromfile(self.name, dtype=np.uint8, count=count, offset=start)


class MemorySource(NamedTuple):
    """A log in memory."""

    data: NDArray[np.uint8]
    name: str = "memory"

    @property
    def size(self) -> int:
        """Number of bytes."""
        return len(self.data)

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Return the bytes from start to stop, fewer where the log ends."""
        return self.data[start:stop]


def held(source: ByteSource) -> ByteSource:
    """Return a small log in memory, to decode many types from it; a large one as it is."""
    if source.size > SMALL_BYTES:
        return source
    return MemorySource(source.read(0, source.size), source.name)


def mapped(source: ByteSource) -> ByteSource:
    """Return a small log in a file as memory that the system keeps it in; others as they are.

    Nothing is copied then. A log must not shrink while it is read so: the system ends a process
    that reads beyond the end.
    """
    if source.size > SMALL_BYTES or not isinstance(source, FileSource):
        return source
    try:
        data = np.asarray(np.memmap(source.name, dtype=np.uint8, mode="r"))
    except (OSError, ValueError):  # a file system that maps nothing, or the log is empty by now
        return source
    return MemorySource(data[: source.size], source.name)


def windows(source: ByteSource, window_bytes: int = WINDOW_BYTES) -> Iterator[NDArray[np.uint8]]:
    """Yield the log's bytes in order, window by window."""
    for start in range(0, source.size, window_bytes):
        yield source.read(start, start + window_bytes)


def open_source(path: str | os.PathLike[str]) -> ByteSource:
    """Return the file as a source; LogFileError says in one line why it cannot be one."""
    name = os.fspath(path)
    try:
        with open(name, "rb") as file:  # noqa: PTH123  # a Path takes longer to import
            head = file.read(16)
            size = os.fstat(file.fileno()).st_size
    except IsADirectoryError:
        raise LogFileError(
            f"{name} is a folder: name a .tlog in it, or let summary read them all"
        ) from None
    except FileNotFoundError:
        raise LogFileError(f"{name}: no such file; check the path") from None
    except OSError as error:
        raise LogFileError(f"{name} cannot be read: {error.strerror}") from error
    kind = next((kind for magic, kind in MISTAKEN.items() if head.startswith(magic)), None)
    if kind is not None:
        raise LogFileError(f"{name} is {kind}")
    if size == 0:
        raise LogFileError(f"{name} is empty: nothing was logged")
    return FileSource(name, size)
