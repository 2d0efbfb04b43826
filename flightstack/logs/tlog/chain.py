"""Find the packets of some messages only, where the records of a log stand in an unbroken chain.

A record begins where the one before it ends. Where this holds from the first byte of a log to the
last, what lies between is known without a checksum, and only the packets that were asked for are
checked. What comes out is what a whole read would select: wherever that is not certain, nothing
comes out, and the log has to be read whole.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import packet_tables
from flightstack.logs.tlog.clock import RunningClock
from flightstack.logs.tlog.packet_search import (
    Bytes,
    Candidates,
    Positions,
    describe,
    find_headers,
    holds_checksum,
    known,
    record_times,
)
from flightstack.logs.tlog.packets import MARGIN, TIMESTAMP, Packets, join
from flightstack.logs.tlog.source import WINDOW_BYTES, ByteSource

# marks of a byte: a time after a record ends here, a record starts here, and one of the chain does
FOLLOWS, BEGINS, IN_CHAIN = 1, 2, 4


def _without_strays(position: Positions, end: Positions) -> NDArray[np.bool_]:
    """Return which rows follow one another from the first on; those between them are strays."""
    keep = np.ones(len(position), dtype=np.bool_)
    row = 0
    for last in np.flatnonzero(position[1:] != end[:-1] + TIMESTAMP).tolist():
        if last >= row:  # in the chain, unlike the row after it
            row = int(np.searchsorted(position, end[last] + TIMESTAMP))
            keep[last + 1 : row] = False
    return keep


def _chained(position: Positions, end: Positions, marks: Bytes) -> NDArray[np.intp]:
    """Return the rows of those that stand in a chain of records from byte 0 on.

    `marks` has room for the window, a time and one byte more, where the last record may end.
    """
    marks.fill(0)
    after = end + TIMESTAMP
    marks[after] = FOLLOWS
    marks[TIMESTAMP] = FOLLOWS
    follows = marks[position]
    marks[position] = follows | BEGINS
    marks[-1] |= BEGINS
    rows = np.flatnonzero(follows & (marks[after] >> 1))
    return rows[_without_strays(position[rows], end[rows])]


def _is_unbroken(position: Positions, end: Positions) -> bool:
    opens_first = len(position) > 0 and bool(position[0] == TIMESTAMP)
    return opens_first and bool((position[1:] == end[:-1] + TIMESTAMP).all())


def _wanted(data: Bytes, headers: Candidates, msgids: list[int]) -> Candidates:
    """Return the candidates that have one of these ids and may be whole."""
    low_bytes = np.zeros(256, dtype=np.bool_)
    low_bytes[[msgid & 0xFF for msgid in msgids]] = True
    low = data[headers.position + np.where(headers.is_v2, 7, 5)]
    found = known(data, headers.take(np.flatnonzero(low_bytes[low])))
    wanted = np.zeros(len(packet_tables().ids), dtype=np.bool_)
    wanted[np.searchsorted(packet_tables().ids, msgids)] = True
    return found.take(np.flatnonzero(wanted[found.row]))


def _in_window(
    data: Bytes, msgids: list[int], marks: Bytes, *, is_last: bool
) -> tuple[Packets, Positions, int] | None:
    """Return the wanted packets, the times of all records, and where the last of them ends.

    `data` begins with a record. None where the chain breaks, or a wanted packet is damaged, or one
    stands outside the chain.
    """
    found = find_headers(data)
    end = found.end
    rows = _chained(found.position, end, marks[: len(data) + TIMESTAMP + 1])
    if not is_last:
        rows = rows[found.position[rows] < len(data) - MARGIN]
    position = found.position[rows]
    stop = int(end[rows[-1]]) if len(rows) else 0
    if not _is_unbroken(position, end[rows]) or (is_last and stop != len(data)):
        return None
    wanted = _wanted(data, found, msgids)
    wanted = wanted.take(wanted.position < stop)
    holds = holds_checksum(data, wanted)
    marks[position] = IN_CHAIN
    if not np.array_equal(holds, marks[wanted.position] == IN_CHAIN):
        return None
    packets = wanted.take(holds)
    free_from = packets.position - TIMESTAMP
    times = record_times(data, position, position - TIMESTAMP)
    return describe(data, packets, record_times(data, packets.position, free_from)), times, stop


def find_chained(
    source: ByteSource, msgids: list[int], window_bytes: int = WINDOW_BYTES
) -> Packets | None:
    """Return the packets with these ids, all of them known, in file order.

    None where the log has to be read whole: its chain of records is broken, or its clock jumps.
    """
    parts: list[Packets] = []
    clock = RunningClock()
    marks = np.empty(window_bytes + TIMESTAMP + 1, dtype=np.uint8)  # once, not a window
    edge = 0
    while edge < source.size:
        data = source.read(edge, edge + window_bytes)
        found = _in_window(data, msgids, marks, is_last=edge + window_bytes >= source.size)
        if found is None or not clock.runs_on(found[1]):
            return None
        packets, _, stop = found
        parts.append(replace(packets, offset=packets.offset + edge))
        edge += stop
    return join(parts) if parts else None
