"""Turn the bytes of a log, as they come, into packets: window by window, or while it is written."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.packet_search import find_packets
from flightstack.logs.tlog.packets import MARGIN, MAX_PACKET, TIMESTAMP, Packets, join
from flightstack.logs.tlog.source import WINDOW_BYTES, ByteSource, windows
from flightstack.logs.tlog.unknown import find_unknown


def merge(known: Packets, unknown: Packets | None) -> Packets:
    """Return both in file order."""
    if unknown is None:
        return known
    both = join([known, unknown])
    return both.take(np.argsort(both.offset, kind="stable"))


class Scanner:
    """Finds packets in bytes that are fed piece by piece; keeps only what is not yet decided."""

    def __init__(self) -> None:
        self._tail = np.empty(0, dtype=np.uint8)
        self._tail_offset = 0  # where the tail stands in the log

    def feed(self, data: NDArray[np.uint8], *, margin: int) -> Packets:
        """Return the packets that the log has up to `margin` bytes before its present end.

        With margin 0 every whole packet is taken at once: for the end of a file, or a live log.
        """
        buffer = np.concatenate((self._tail, data))
        limit = max(0, len(buffer) - margin)
        known = find_packets(buffer, free_from=0, limit=limit)
        unknown = find_unknown(buffer, known, free_from=0, limit=limit)
        packets = merge(known, unknown)
        decided = int(packets.end[-1]) if len(packets) else 0
        kept = max(decided, len(buffer) - margin - MAX_PACKET - TIMESTAMP)  # all undecided
        packets = replace(packets, offset=packets.offset + self._tail_offset)
        self._tail = buffer[kept:].copy()
        self._tail_offset += kept
        return packets


def scan(source: ByteSource, window_bytes: int = WINDOW_BYTES) -> Iterator[Packets]:
    """Yield the packets of a log, window by window, in file order."""
    scanner = Scanner()
    for data in windows(source, window_bytes):
        yield scanner.feed(data, margin=MARGIN)
    yield scanner.feed(np.empty(0, dtype=np.uint8), margin=0)
