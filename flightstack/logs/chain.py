"""Find the frames of some messages only, where the records of a log stand in an unbroken chain.

A record begins where the one before it ends. Where this holds from the first byte of a log to the
last, what lies between is known without a checksum, and only the frames that were asked for are
checked. What comes out is what a whole read would select: wherever that is not certain, nothing
comes out, and the log has to be read whole.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.clock import RunningClock
from flightstack.logs.dialect import framing_tables
from flightstack.logs.frames import MARGIN, TIMESTAMP, Frames, join
from flightstack.logs.framing import (
    Bytes,
    Candidates,
    Positions,
    describe,
    find_headers,
    holds_checksum,
    record_times,
)
from flightstack.logs.source import WINDOW_BYTES, Source

FOLLOWS, BEGINS = 1, 2  # marks of a byte: a time after a record ends here, a record starts here


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
    marks[end + TIMESTAMP] = FOLLOWS
    marks[TIMESTAMP] = FOLLOWS
    marks[position] |= BEGINS
    marks[-1] |= BEGINS
    rows = np.flatnonzero((marks[position] & FOLLOWS) & (marks[end + TIMESTAMP] >> 1))
    return rows[_without_strays(position[rows], end[rows])]


def _is_unbroken(position: Positions, end: Positions) -> bool:
    opens_first = len(position) > 0 and bool(position[0] == TIMESTAMP)
    return opens_first and bool((position[1:] == end[:-1] + TIMESTAMP).all())


def _wanted(found: Candidates, msgids: list[int]) -> NDArray[np.intp]:
    """Return the rows of the candidates that have one of these ids and may be whole."""
    tables = framing_tables()
    asked = np.zeros(len(tables.ids) + 1, dtype=np.bool_)  # one more: row -1 is unknown
    asked[np.searchsorted(tables.ids, msgids)] = True
    rows = np.flatnonzero(asked.take(found.row))
    fits = found.is_v2[rows] | (found.length[rows] <= tables.size[found.row[rows]])
    return rows[fits]


def _in_window(
    data: Bytes, msgids: list[int], marks: Bytes, *, is_last: bool
) -> tuple[Frames, Positions, int] | None:
    """Return the wanted frames, the times of all records, and where the last of them ends.

    `data` begins with a record. None where the chain breaks, or a wanted frame is damaged, or one
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
    in_chain = np.zeros(len(end), dtype=np.bool_)
    in_chain[rows] = True
    wanted = _wanted(found, msgids)
    wanted = wanted[found.position[wanted] < stop]
    asked = found.take(wanted)
    holds = holds_checksum(data, asked)
    if not np.array_equal(holds, in_chain[wanted]):
        return None
    frames = asked.take(holds)
    free_from = frames.position - TIMESTAMP
    times = record_times(data, position, position - TIMESTAMP)
    return describe(data, frames, record_times(data, frames.position, free_from)), times, stop


def find_chained(
    source: Source, msgids: list[int], window_bytes: int = WINDOW_BYTES
) -> Frames | None:
    """Return the frames with these ids, all of them known, in file order.

    None where the log has to be read whole: its chain of records is broken, or its clock jumps.
    """
    parts: list[Frames] = []
    clock = RunningClock()
    marks = np.empty(window_bytes + TIMESTAMP + 1, dtype=np.uint8)  # once, not a window
    edge = 0
    while edge < source.size:
        data = source.read(edge, edge + window_bytes)
        found = _in_window(data, msgids, marks, is_last=edge + window_bytes >= source.size)
        if found is None or not clock.runs_on(found[1]):
            return None
        frames, _, stop = found
        parts.append(replace(frames, offset=frames.offset + edge))
        edge += stop
    return join(parts) if parts else None
