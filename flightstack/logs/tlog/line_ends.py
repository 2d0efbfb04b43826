"""Tell and undo what a program did that took a log for text, and converted its line ends.

A byte of ten (line feed) became thirteen and ten, in a copy through FTP in text mode or a version
control system: undone, all is as it was. Where instead every thirteen became ten, it is told only.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.packets import TIMESTAMP, Packets
from flightstack.logs.tlog.source import ByteSource, windows

RETURN, FEED = 0x0D, 0x0A
MIN_ENDS = 12  # fewer pairs stand in a file by chance
MIN_SHARE = 0.98  # of the line feeds that follow a return
MIN_BYTES = 8192  # in which a byte that occurs nowhere is strange


class RestoredSource(NamedTuple):
    """A log in memory whose line ends were converted, as it was before."""

    data: NDArray[np.uint8]
    name: str
    removed: int  # bytes that the conversion had added

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


def restored_line_ends(source: ByteSource, packets: Packets) -> RestoredSource | None:
    """Return the log as it was before every feed became a return and a feed; None where not so."""
    if isinstance(source, RestoredSource) or not _has_gaps(source, packets):
        return None
    ends = _count(source)
    if ends.pairs < max(MIN_ENDS, MIN_SHARE * ends.feeds):
        return None
    data = np.concatenate(list(_without_returns(source)))
    return RestoredSource(data, source.name, source.size - len(data))


def line_ends_said(source: ByteSource, packets: Packets) -> str:
    """Return what a conversion did to the file, in words; "" for nothing."""
    if isinstance(source, RestoredSource):
        return f"line feeds had become CR LF: undone, {source.removed} bytes taken out"
    if source.size < MIN_BYTES or not _has_gaps(source, packets):
        return ""
    ends = _count(source)
    if ends.feeds >= MIN_ENDS and not ends.returns:
        return "no byte is a carriage return: they became line feeds in a conversion of line ends"
    if ends.returns >= MIN_ENDS and not ends.feeds:
        return "no byte is a line feed: a conversion of line ends took them"
    return ""
