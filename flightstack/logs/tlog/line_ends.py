"""Tell and undo what a program did that took a log for text, and converted its line ends.

A byte of ten (line feed) became thirteen and ten, in a copy through FTP in text mode or a version
control system: undone, all is as it was. Where instead every thirteen became ten, the checksums of
the packets that are hit tell which tens to turn back.
"""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.packet_search import find_packets
from flightstack.logs.tlog.packets import TIMESTAMP, Packets
from flightstack.logs.tlog.source import ByteSource, windows

RETURN, FEED = 0x0D, 0x0A
LOST_RETURNS = "no byte is a carriage return: a conversion of line ends made line feeds of them"
MIN_PAIRS = 3  # where every feed follows a return: fewer may do so by chance
MIN_ENDS = 12  # of one kind, to find it strange that there is none of the other
MIN_SHARE = 0.98  # of the line feeds that follow a return
MAX_TURNED = 7  # feeds in one gap: all ways to turn some of them back are tried
MAX_GAPS = 2000  # that are mended so
MIN_BYTES = 8192  # in which a byte that occurs nowhere is strange


class RestoredSource(NamedTuple):
    """A log in memory whose line ends were converted, as it was before."""

    data: NDArray[np.uint8]
    name: str
    said: str  # what had happened to it, and what was undone

    @property
    def size(self) -> int:
        """Number of bytes."""
        return len(self.data)

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Return the bytes from start to stop, fewer where the log ends."""
        return self.data[start:stop]


class _Ends(NamedTuple):
    """How many line ends of each kind a file holds."""

    returns: int
    feeds: int
    pairs: int  # a return, then a feed


def _count(source: ByteSource) -> _Ends:
    returns = feeds = pairs = 0
    last = 0
    for data in windows(source):
        is_return, is_feed = data == RETURN, data == FEED
        returns += int(np.count_nonzero(is_return))
        feeds += int(np.count_nonzero(is_feed))
        pairs += int(np.count_nonzero(is_return[:-1] & is_feed[1:]))
        pairs += last == RETURN and bool(is_feed[0])
        last = int(data[-1])
    return _Ends(returns, feeds, pairs)


def _without_returns(source: ByteSource) -> Iterator[NDArray[np.uint8]]:
    """Yield the bytes without the returns that stand before feeds."""
    for start in range(0, source.size, 1 << 20):
        data = source.read(start, start + (1 << 20) + 1)
        follows = np.zeros(min(len(data), 1 << 20), dtype=np.bool_)
        rest = data[1:]
        follows[: len(rest)] = rest[: len(follows)] == FEED
        own = data[: len(follows)]
        yield own[~(follows & (own == RETURN))]


def _has_gaps(source: ByteSource, packets: Packets) -> bool:
    """Return whether something stands between the packets that is not their time."""
    if not len(packets):
        return True
    space = packets.offset[1:] - packets.end[:-1]
    ends_early = int(packets.end[-1]) < source.size
    return ends_early or bool(((space != TIMESTAMP) & (space != 0)).any())


def _lost_returns(ends: _Ends) -> bool:
    return ends.feeds >= MIN_ENDS and not ends.returns


def restored_line_ends(source: ByteSource, packets: Packets) -> RestoredSource | None:
    """Return the log as it was before its line ends were converted; None where they were not."""
    if isinstance(source, RestoredSource) or not _has_gaps(source, packets):
        return None
    ends = _count(source)
    if _lost_returns(ends):
        return _turned_back(source, packets)
    if ends.pairs < max(MIN_PAIRS, MIN_SHARE * ends.feeds):
        return None
    data = np.concatenate(list(_without_returns(source)))
    said = f"line feeds had become CR LF: undone, {source.size - len(data)} bytes taken out"
    return RestoredSource(data, source.name, said)


def _turned_back(source: ByteSource, packets: Packets) -> RestoredSource | None:
    """Return the log with feeds between its packets turned into returns where that makes packets.

    None where it makes none.
    """
    data = source.read(0, source.size).copy()
    edges = np.r_[np.int64(0), packets.end]
    wide = np.flatnonzero(np.r_[packets.offset, np.int64(source.size)] - edges > TIMESTAMP)
    stops = np.r_[packets.offset, np.int64(source.size)]
    turned = 0
    for gap in wide[:MAX_GAPS].tolist():
        part = data[int(edges[gap]) : int(stops[gap])]
        turned += _turn_back(part)
    if not turned:
        return None
    said = f"{LOST_RETURNS}: {turned} were turned back by the checksums"
    return RestoredSource(data, source.name, said)


def _turn_back(part: NDArray[np.uint8]) -> int:
    """Turn those feeds of a gap into returns that make most packets in it; return how many."""
    feeds = np.flatnonzero(part == FEED)
    if not 0 < len(feeds) <= MAX_TURNED:
        return 0
    best, chosen = 0, feeds[:0]
    for choice in product((False, True), repeat=len(feeds)):
        tried = part.copy()
        tried[feeds[list(choice)]] = RETURN
        found = find_packets(tried, free_from=0, limit=len(tried))
        covered = int((found.end - found.offset).sum())
        if covered > best:
            best, chosen = covered, feeds[list(choice)]
    part[chosen] = RETURN
    return len(chosen)


def line_ends_said(source: ByteSource, packets: Packets) -> str:
    """Return what a conversion did to the file, in words; "" for nothing."""
    if isinstance(source, RestoredSource):
        return source.said
    if source.size < MIN_BYTES or not _has_gaps(source, packets):
        return ""
    ends = _count(source)
    if _lost_returns(ends):
        return LOST_RETURNS
    if ends.returns >= MIN_ENDS and not ends.feeds:
        return "no byte is a line feed: a conversion of line ends took them"
    return ""
