"""Read a large tlog in parts, each a log of its own: memory stays bounded whatever the size.

A part ends where no autopilot is armed, so that a flight is not torn; only where one stays armed
for very long, it ends all the same.
"""

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.reading import from_packets, read
from flightstack.logs.dialect.message_types import message_id
from flightstack.logs.progress import progress
from flightstack.logs.tlog.packets import Packets, join
from flightstack.logs.tlog.scanner import scan
from flightstack.logs.tlog.source import WINDOW_BYTES, ByteSource, open_source

LARGE_BYTES = 256 << 20  # what this project's own logs are cut at; larger ones are read in parts
PART_PACKETS = 1_000_000
LEAST_REST = 4  # a rest that is less than this fraction of a part is no part of its own
MAX_PARTS = 3  # so many times more packets until a part ends in flight, too
ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
BEAT = message_id("HEARTBEAT")

Progress = Callable[[int], None]  # told how many bytes of the log are done


@dataclass(frozen=True, slots=True, eq=False)
class PartSource:
    """A stretch of a log's bytes."""

    whole: ByteSource
    start: int
    stop: int

    @property
    def name(self) -> str:
        """What to call the log in messages."""
        return self.whole.name

    @property
    def size(self) -> int:
        """Number of bytes."""
        return self.stop - self.start

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Return the bytes from start to stop of the stretch, fewer where it ends."""
        first = self.start + start
        return self.whole.read(first, max(first, min(self.start + stop, self.stop)))


@dataclass(frozen=True, slots=True, eq=False)
class LogPart:
    """A part of a large log, and where in the file it starts."""

    log: Log
    start: int


def is_large(path: str | os.PathLike[str]) -> bool:
    """Return whether a log is better read in parts; False where there is no such file."""
    try:
        return os.stat(path).st_size > LARGE_BYTES  # noqa: PTH116  # a Path takes longer to import
    except OSError:
        return False


class _Arming:
    """Follows who is armed through the HEARTBEATs of a log."""

    def __init__(self) -> None:
        self._armed: set[int] = set()

    def follow(self, source: ByteSource, packets: Packets) -> bool:
        """Return whether anybody is armed after these packets."""
        beats = packets.take(packets.msgid == BEAT)
        if len(beats):
            beats_log = Log(source, beats, beats.time_us)
            modes = beats_log["HEARTBEAT"]["base_mode"].tolist()
            for sender, mode in zip(beats.sender.tolist(), modes, strict=True):
                (self._armed.add if mode & ARMED else self._armed.discard)(sender)
        return bool(self._armed)


def _part(source: ByteSource, pieces: list[Packets], start: int, stop: int) -> LogPart:
    """Return the packets as a log of the bytes from start to stop; empties `pieces`."""
    packets = join(pieces)
    moved = replace(packets, offset=packets.offset - start)
    return LogPart(from_packets(PartSource(source, start, stop), moved), start)


def read_parts(
    path: str | os.PathLike[str],
    *,
    part_packets: int | None = None,
    window_bytes: int = WINDOW_BYTES,
    report: Progress | None = None,
) -> Iterator[LogPart]:
    """Yield a tlog in parts of about so many packets; LogFileError for what is no log."""
    source = open_source(path)
    enough = PART_PACKETS if part_packets is None else part_packets
    arming = _Arming()
    pieces: list[Packets] = []
    start = count = 0
    for packets in scan(source, window_bytes):
        if not len(packets):
            continue
        pieces.append(packets)
        count += len(packets)
        stop = int(packets.end[-1])
        may_end = not arming.follow(source, packets) or count >= MAX_PARTS * enough
        if report is not None:
            report(stop)
        leaves_enough = (source.size - stop) * LEAST_REST >= stop - start
        if may_end and leaves_enough and count >= enough:
            yield _part(source, pieces, start, stop)
            start, count = stop, 0
    if pieces or start < source.size:
        yield _part(source, pieces, start, source.size)


def logs_of(log: str | Path) -> Iterator[Log]:
    """Yield a log; a large one in parts, in order, while the terminal shows how far it is."""
    if not is_large(log):
        yield read(log)
        return
    path = Path(log)
    with progress(path.name, path.stat().st_size) as done:
        for part in read_parts(path, report=done):
            yield part.log
