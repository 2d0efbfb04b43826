"""Find every whole packet in a stretch of bytes, whatever lies between the packets.

Every byte that could start a packet is a candidate; a candidate is a packet if its checksum holds.
That alone finds every packet behind any damage, and about one in 65,536 candidates by chance. Two
rules keep those out: a packet that stands in the chain of records (its neighbours begin where it
ends) beats one that overlaps it, and a version 1 packet that stands alone must have a plausible
time or the full length of its message, with or without what version 2 added to it (version 2
headers are too specific to arise by chance).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import packet_tables
from flightstack.logs.tlog import crc
from flightstack.logs.tlog.byte_view import at_every_byte
from flightstack.logs.tlog.packets import IS_SIGNED, IS_V2, NO_TIME, TIMESTAMP, Packets
from flightstack.mavlink_numbers import (
    CHECKSUM_BYTES,
    HEADER_V1,
    HEADER_V2,
    MAGIC_V2,
    SIGNATURE_BYTES,
    SIGNED_FLAG,
)

MIN_PACKET = HEADER_V1 + CHECKSUM_BYTES
SEARCH_BLOCK = 1 << 17
PLAUSIBLE_TIME_US = (10**15, 41 * 10**14)  # 2001 to 2099

Bytes = NDArray[np.uint8]
Positions = NDArray[np.int64]


class Candidates(NamedTuple):
    """Places where a header of a known message stands whole, in order of position."""

    position: Positions
    is_v2: NDArray[np.bool_]
    is_signed: NDArray[np.bool_]
    length: NDArray[np.int64]  # of the payload
    row: NDArray[np.int32]  # in packet_tables(); -1 where unknown, or not looked up

    def take(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "Candidates":
        """Return the candidates of these rows."""
        return Candidates._make(column[rows] for column in self)

    @property
    def checksum_at(self) -> Positions:
        """Position of each candidate's checksum."""
        return self.position + np.where(self.is_v2, HEADER_V2, HEADER_V1) + self.length

    @property
    def end(self) -> Positions:
        """Position of the first byte after each candidate."""
        tail = np.where(self.is_signed, CHECKSUM_BYTES + SIGNATURE_BYTES, CHECKSUM_BYTES)
        return self.checksum_at + tail


def message_rows(data: Bytes, position: Positions, is_v2: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return the row in packet_tables() of the message at each position, -1 where unknown."""
    tables = packet_tables()
    low = data[position + np.where(is_v2, 7, 5)].astype(np.int32)
    last = len(data) - 1
    middle = data[np.minimum(position + 8, last)].astype(np.int32)
    high = data[np.minimum(position + 9, last)]
    rows: NDArray[np.int32] = tables.row_of_low_id[low | np.where(is_v2, middle << 8, 0)]
    far = np.flatnonzero(is_v2 & (high != 0))
    if len(far):
        msgid = low[far] | middle[far] << 8 | high[far].astype(np.int32) << 16
        row = np.searchsorted(tables.ids, msgid)
        is_known = tables.ids.take(row, mode="clip") == msgid
        rows[far] = np.where(is_known, row, -1)
    return rows


def magic_positions(data: Bytes) -> Positions:
    """Return where a byte is 0xFD or 0xFE, block by block so that all stays in the cache."""
    blocks = []
    for start in range(0, len(data), SEARCH_BLOCK):
        block = data[start : start + SEARCH_BLOCK]
        found = np.flatnonzero((block - np.uint8(MAGIC_V2)) < 2)
        found += start
        blocks.append(found)
    return np.concatenate(blocks) if blocks else np.empty(0, dtype=np.int64)


def find_headers(data: Bytes) -> Candidates:
    """Return the places where a whole packet of any message may start; none is looked up."""
    position = magic_positions(data[: max(0, len(data) - MIN_PACKET + 1)])
    is_v2 = data[position] == MAGIC_V2
    incompatible = data[position + 2]
    headers = Candidates(
        position,
        is_v2,
        is_v2 & (incompatible == SIGNED_FLAG),
        data[position + 1].astype(np.int64),
        np.full(len(position), -1, dtype=np.int32),
    )
    whole = headers.end <= len(data)
    return headers.take(np.flatnonzero(whole & ~(is_v2 & (incompatible > SIGNED_FLAG))))


def known(data: Bytes, headers: Candidates) -> Candidates:
    """Return the headers of messages in the dialect, with payloads that they may have."""
    rows = message_rows(data, headers.position, headers.is_v2)
    fits = headers.is_v2 | (headers.length <= packet_tables().size[rows])
    return headers._replace(row=rows).take(np.flatnonzero((rows >= 0) & fits))


def find_candidates(data: Bytes) -> Candidates:
    """Return the places where a whole packet of a known message may start."""
    return known(data, find_headers(data))


def holds_checksum(data: Bytes, candidates: Candidates) -> NDArray[np.bool_]:
    """Return which candidates are packets: those whose checksum holds."""
    if len(candidates.position) == 0:
        return np.empty(0, dtype=np.bool_)
    at = candidates.checksum_at
    state = crc.checksums(data, candidates.position + 1, at - candidates.position - 1)
    expected = crc.step(state, packet_tables().crc_extra[candidates.row])
    stored = data[at].astype(np.uint16) | data[at + 1].astype(np.uint16) << 8
    result: NDArray[np.bool_] = expected == stored
    return result


def chain_links(position: Positions, end: Positions, size: int) -> NDArray[np.int64]:
    """Return how many neighbours (0 to 2) each packet joins, eight bytes of time between them.

    A stream without times, packets end to end, counts as joined too.
    """
    starts = np.zeros(size + TIMESTAMP + 1, dtype=np.bool_)
    ends = np.zeros(size + TIMESTAMP + 1, dtype=np.bool_)
    starts[position] = True
    ends[end + TIMESTAMP] = True  # shifted, so that no index is negative
    after = starts[end] | starts[end + TIMESTAMP]
    before = ends[position] | ends[position + TIMESTAMP]
    return before.astype(np.int64) + after


def without_overlaps(position: Positions, end: Positions, links: NDArray[np.int64]) -> Positions:
    """Return the rows to keep where packets overlap: first the best linked, then the earliest."""
    reach = np.maximum.accumulate(end)
    opens = np.flatnonzero(np.r_[True, position[1:] >= reach[:-1]])
    sizes = np.diff(np.r_[opens, len(position)])
    keep = np.ones(len(position), dtype=np.bool_)
    for first, size in zip(opens[sizes > 1].tolist(), sizes[sizes > 1].tolist(), strict=True):
        rows = sorted(range(first, first + size), key=lambda row: (-links[row], position[row]))
        taken: list[int] = []
        for row in rows:
            if all(position[row] >= end[other] or end[row] <= position[other] for other in taken):
                taken.append(row)
        keep[first : first + size] = False
        keep[taken] = True
    return np.flatnonzero(keep)


def record_times(data: Bytes, position: Positions, free_from: Positions) -> Positions:
    """Return the time before each packet, NO_TIME where these bytes belong to something else."""
    times = np.full(len(position), NO_TIME, dtype=np.int64)
    if len(data) < TIMESTAMP:
        return times
    stamped = position - TIMESTAMP >= free_from
    words = at_every_byte(data, ">u8")
    times[stamped] = words[position[stamped] - TIMESTAMP].astype(np.uint64).view(np.int64)
    return times


def stands(found: Candidates, times: Positions, links: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which packets are beyond doubt: see the rule for version 1 in the first lines."""
    earliest, latest = PLAUSIBLE_TIME_US
    plausible = (times >= earliest) & (times <= latest)
    tables = packet_tables()
    whole = found.length == tables.size[found.row]
    whole |= found.length == tables.base_size[found.row]
    beyond_doubt: NDArray[np.bool_] = found.is_v2 | (links > 0) | plausible | whole
    return beyond_doubt


def describe(data: Bytes, found: Candidates, times: Positions) -> Packets:
    """Return the index rows of packets; offsets are positions in `data`."""
    tables = packet_tables()
    sequence_at = found.position + np.where(found.is_v2, 4, 2)
    flags = found.is_v2 * IS_V2 + found.is_signed * IS_SIGNED
    return Packets(
        offset=found.position,
        time_us=times,
        msgid=tables.ids[found.row],
        system=data[sequence_at + 1],
        component=data[sequence_at + 2],
        sequence=data[sequence_at],
        length=found.length.astype(np.uint8),
        flags=flags.astype(np.uint8),
        extra=tables.crc_extra[found.row].astype(np.uint8),
    )


def find_packets(data: Bytes, *, free_from: int, limit: int) -> Packets:
    """Return the packets of known messages in `data` that start at or after `free_from`.

    `free_from` is where the last packet before ended; packets from `limit` on are left for the next
    stretch. Offsets are positions in `data`.
    """
    found = find_candidates(data)
    found = found.take(found.position >= free_from)
    found = found.take(holds_checksum(data, found))
    if len(found.position) == 0:
        return describe(data, found, np.empty(0, dtype=np.int64))
    end = found.end
    overlap = bool((found.position[1:] < np.maximum.accumulate(end)[:-1]).any())
    if not overlap and found.is_v2.all():  # the usual case: nothing to weigh
        times = record_times(data, found.position, np.r_[np.int64(free_from), end[:-1]])
    else:
        links = chain_links(found.position, end, len(data))
        rows = without_overlaps(found.position, end, links)
        found, end = found.take(rows), end[rows]
        times = record_times(data, found.position, np.r_[np.int64(free_from), end[:-1]])
        stand = stands(found, times, links[rows])
        found, times = found.take(stand), times[stand]
    kept = found.position < limit
    return describe(data, found.take(kept), times[kept])
