"""Count and locate what a log has lost: bytes that are no packets, and times."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog import clock
from flightstack.logs.tlog.line_ends import line_ends_said
from flightstack.logs.tlog.packets import TIMESTAMP, Packets, packet_length
from flightstack.logs.tlog.source import ByteSource
from flightstack.mavlink_numbers import HEADER_V2


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A stretch of the file that holds no packet."""

    offset: int
    length: int
    time_us: int  # of the last record before it
    kind: str  # "damaged frame", "foreign bytes" or "cut"


@dataclass(frozen=True, slots=True, kw_only=True)
class Damage:
    """All that a log has lost."""

    regions: tuple[Region, ...]
    has_times: bool  # False: a raw stream without times
    mended_times: int
    jumps: tuple[clock.ClockJump, ...]
    duplicates: int  # records that stand in the file twice
    line_ends: str  # what a conversion of line ends did to the file; "" for nothing

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
        found = (self.regions, self.jumps, self.mended_times, self.duplicates, self.line_ends)
        return not any(found)


def _kind(source: ByteSource, offset: int, length: int) -> str:
    head = source.read(offset, offset + TIMESTAMP + HEADER_V2)
    expected = packet_length(head[TIMESTAMP:])
    if offset + length == source.size and (length < TIMESTAMP + 3 or expected > length - TIMESTAMP):
        return "cut"
    return "damaged frame" if expected == length - TIMESTAMP else "foreign bytes"


def find_regions(
    source: ByteSource, packets: Packets, times: NDArray[np.int64], *, has_times: bool
) -> list[Region]:
    """Return the stretches without a packet; `has_times`: records have times before them."""
    if not len(packets):
        whole = (0, source.size)
        return [_region(source, *whole, 0)] if source.size else []
    end = packets.end
    space = packets.offset.copy()  # before each packet
    space[1:] -= end[:-1]
    gap = TIMESTAMP if has_times else 0
    regions = []
    for row in np.flatnonzero(space > gap).tolist():
        offset = int(end[row - 1]) if row else 0
        time_us = int(times[max(row - 1, 0)])
        regions.append(_region(source, offset, int(space[row]) - gap, time_us))
    rest = source.size - int(end[-1])
    if rest:
        regions.append(_region(source, int(end[-1]), rest, int(times[-1])))
    return regions


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
    stamps = packets.time_us
    has_times = clock.has_stamps(stamps)
    regions = find_regions(source, packets, time_us, has_times=has_times)
    if clock.is_even(stamps) or not has_times:
        mended, jumps = 0, []
    else:
        mended = int(np.count_nonzero(~clock.sound_stamps(stamps)))
        jumps = clock.jumps(stamps, time_us)
    backwards = any(jump.jump_us < 0 for jump in jumps)
    return Damage(
        regions=tuple(regions),
        has_times=has_times,
        mended_times=mended,
        jumps=tuple(jumps),
        duplicates=count_duplicates(packets, stamps) if backwards else 0,
        line_ends=line_ends_said(source, packets),
    )
