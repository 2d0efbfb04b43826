"""Count and locate what a log has lost: bytes that are no packets, times, and sequence numbers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog import clock
from flightstack.logs.tlog.packets import (
    HEADER_V2,
    LINK_BITS,
    TIMESTAMP,
    Packets,
    packet_length,
)
from flightstack.logs.tlog.source import ByteSource

REORDERED = 128  # a step this far ahead in sequence numbers of 8 bits is a step back


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A stretch of the file that holds no packet."""

    offset: int
    length: int
    time_us: int  # of the last record before it
    kind: str  # "damaged frame", "foreign bytes" or "cut"


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceLoss:
    """What one sender's sequence numbers tell about the link."""

    system: int
    component: int
    received: int
    lost: int
    repeated: int  # the same sequence number twice in a row
    reordered: int  # steps back: reordering, a restart, or two links in one log

    @property
    def fraction(self) -> float:
        """Lost over sent, 0 to 1."""
        return self.lost / (self.lost + self.received) if self.received else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """All that a log has lost."""

    regions: tuple[Region, ...]
    has_times: bool  # False: a raw stream without times
    mended_times: int
    jumps: tuple[clock.ClockJump, ...]
    duplicates: int  # records that stand in the file twice

    @property
    def lost_bytes(self) -> int:
        """Number of bytes that belong to no record."""
        return sum(region.length for region in self.regions)

    @property
    def is_cut(self) -> bool:
        """Whether the log ends within a record."""
        return bool(self.regions) and self.regions[-1].kind == "cut"

    @property
    def is_clean(self) -> bool:
        """Whether nothing at all was lost."""
        return not (self.regions or self.jumps or self.mended_times or self.duplicates)


def _kind(source: ByteSource, offset: int, length: int) -> str:
    head = source.read(offset, offset + TIMESTAMP + HEADER_V2)
    expected = packet_length(head[TIMESTAMP:])
    if offset + length == source.size and (length < TIMESTAMP + 3 or expected > length - TIMESTAMP):
        return "cut"
    return "damaged frame" if expected == length - TIMESTAMP else "foreign bytes"


def find_regions(
    source: ByteSource, packets: Packets, times: NDArray[np.int64]
) -> tuple[list[Region], bool]:
    """Return the stretches without a packet, and whether the records have times before them."""
    if not len(packets):
        whole = (0, source.size)
        return ([_region(source, *whole, 0)] if source.size else []), True
    end = packets.end
    space = packets.offset.copy()  # before each packet
    space[1:] -= end[:-1]
    has_times = np.count_nonzero(space >= TIMESTAMP) * 2 >= len(space)
    gap = TIMESTAMP if has_times else 0
    regions = []
    for row in np.flatnonzero(space > gap).tolist():
        offset = int(end[row - 1]) if row else 0
        time_us = int(times[max(row - 1, 0)])
        regions.append(_region(source, offset, int(space[row]) - gap, time_us))
    rest = source.size - int(end[-1])
    if rest:
        regions.append(_region(source, int(end[-1]), rest, int(times[-1])))
    return regions, bool(has_times)


def _region(source: ByteSource, offset: int, length: int, time_us: int) -> Region:
    kind = _kind(source, offset, length)
    return Region(offset=offset, length=length, time_us=time_us, kind=kind)


def count_duplicates(packets: Packets, times: NDArray[np.int64]) -> int:
    """Return how many records repeat one before: same time, sender, sequence and message."""
    key = packets.msgid.astype(np.int64) << 24
    key |= packets.sender.astype(np.int64) << 8 | packets.sequence
    order = np.lexsort((key, times))
    same = (np.diff(times[order]) == 0) & (np.diff(key[order]) == 0)
    return int(np.count_nonzero(same))


def find_damage(source: ByteSource, packets: Packets, time_us: NDArray[np.int64]) -> Damage:
    """Return what a log has lost, from all of its packets and their mended times."""
    regions, has_times = find_regions(source, packets, time_us)
    _, mended = clock.mend(packets.time_us)
    jumps = tuple(clock.jumps(time_us))
    backwards = any(jump.jump_us < 0 for jump in jumps)
    return Damage(
        regions=tuple(regions),
        has_times=has_times,
        mended_times=mended if has_times else 0,
        jumps=jumps,
        duplicates=count_duplicates(packets, time_us) if backwards else 0,
    )


def _steps(sequence: NDArray[np.uint8]) -> tuple[int, int, int]:
    """Return lost, repeated and reordered of one stream of sequence numbers."""
    step = np.diff(sequence)  # wraps at 256 as the numbers do
    ahead = step[(step > 0) & (step < REORDERED)].astype(np.int64)
    lost = int((ahead - 1).sum())
    return lost, int(np.count_nonzero(step == 0)), int(np.count_nonzero(step >= REORDERED))


def _stream_steps(sequence: NDArray[np.uint8], link: NDArray[np.uint8]) -> tuple[int, int, int]:
    """Return the steps of one sender, by link where that explains the numbers better."""
    together = _steps(sequence)
    parts = [_steps(sequence[link == number]) for number in range(LINK_BITS + 1)]
    by_link = tuple(sum(part[column] for part in parts) for column in range(3))
    better = sum(by_link) < sum(together)
    return (by_link[0], by_link[1], by_link[2]) if better else together


def find_losses(packets: Packets) -> tuple[SourceLoss, ...]:
    """Return what the sequence numbers of every sender tell, in order of system and component."""
    losses = []
    for key in np.unique(packets.sender).tolist():
        rows = packets.sender == key
        link = (packets.time_us[rows] & LINK_BITS).astype(np.uint8)
        lost, repeated, reordered = _stream_steps(packets.sequence[rows], link)
        losses.append(
            SourceLoss(
                system=key >> 8,
                component=key & 0xFF,
                received=int(np.count_nonzero(rows)),
                lost=lost,
                repeated=repeated,
                reordered=reordered,
            )
        )
    return tuple(losses)
