"""Find packets that fail their checksum as the dialect has it, but that fill gaps between packets.

Three kinds do so undamaged. Some senders compute the checksum before they trim trailing zeros from
the payload: padded again it holds. A message may be in no definition, or under another definition
than ours: its CRC_EXTRA is not known, but only one byte can make a checksum hold, for one in 256
wrong checksums none can, and it must be the same byte for every packet of that message. All are
taken only where they fill a gap, record after record.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import OTHER_DEFINITION, packet_tables
from flightstack.logs.tlog import crc
from flightstack.logs.tlog.packet_search import message_rows, record_times
from flightstack.logs.tlog.packets import (
    IS_SIGNED,
    IS_UNKNOWN,
    IS_V2,
    TIMESTAMP,
    Packets,
    packet_length,
)
from flightstack.mavlink_numbers import HEADER_V1, HEADER_V2, MAGIC_V2, SIGNED_FLAG

NO_EXTRA = -1
MIN_AGREEING = 3  # packets of a known message, to believe that they have another definition
MIN_AGREEING_SHARE = 0.9

Bytes = NDArray[np.uint8]
Positions = NDArray[np.int64]


@cache
def _byte_of_state() -> NDArray[np.int16]:
    table = np.full(1 << 16, NO_EXTRA, dtype=np.int16)
    table[crc.byte_table()] = np.arange(256)
    return table


def _packet_end(data: Bytes, at: int) -> int:
    """Return where a packet at `at` ends, -1 where none starts."""
    if at + HEADER_V1 > len(data):
        return -1
    length = packet_length(data[at : at + 3])
    return -1 if not length or at + length > len(data) else at + length


def _walk(data: Bytes, gap: tuple[int, int], limit: int) -> list[int]:
    """Return the positions of packets that fill a gap record by record, from its left edge."""
    left, right = gap
    found: list[int] = []
    edge = left
    while edge + TIMESTAMP < right:
        at = edge + TIMESTAMP
        end = _packet_end(data, at)
        if end < 0 or end > right:
            at, end = edge, _packet_end(data, edge)
        if end < 0 or end > right:
            break
        if at >= limit:
            return found
        found.append(at)
        edge = end
    fills_gap = edge in (right, right - TIMESTAMP)
    return found if fills_gap else found[:-1]


def _inferred_extra(data: Bytes, at: Positions, length: Positions) -> NDArray[np.int16]:
    """Return the one byte that makes each checksum hold, NO_EXTRA where none does."""
    state = crc.checksums(data, at + 1, length)
    check_at = at + 1 + length
    stored = data[check_at].astype(np.uint16) | data[check_at + 1].astype(np.uint16) << 8
    needed = _byte_of_state()[stored ^ state >> 8]
    return np.where(needed == NO_EXTRA, NO_EXTRA, needed ^ (state & 0xFF)).astype(np.int16)


def _padded_holds(data: Bytes, at: int, size: int, extra: int) -> bool:
    """Return whether a version 2 packet's checksum holds with its payload padded to this size."""
    length = int(data[at + 1])
    if length >= size:
        return False
    padded = np.zeros(HEADER_V2 + size, dtype=np.uint8)
    padded[: HEADER_V2 + length] = data[at : at + HEADER_V2 + length]
    padded[1] = size  # the length as it was when the checksum was made
    start, count = np.array([1]), np.array([HEADER_V2 - 1 + size])
    state = crc.checksums(padded, start, count)
    expected = crc.step(state, np.array([extra], dtype=np.uint16))
    check_at = at + HEADER_V2 + length
    return int(expected[0]) == int(data[check_at]) | int(data[check_at + 1]) << 8


def _is_trimmed_late(
    data: Bytes, at: Positions, row: NDArray[np.int32], is_v2: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return which packets fit their checksum as they were before trailing zeros were trimmed."""
    tables = packet_tables()
    fits = np.zeros(len(at), dtype=np.bool_)
    for index in np.flatnonzero((row >= 0) & is_v2).tolist():
        sizes = {int(tables.size[row[index]]), int(tables.base_size[row[index]])}
        extra = int(tables.crc_extra[row[index]])
        fits[index] = any(_padded_holds(data, int(at[index]), size, extra) for size in sizes)
    return fits


def _gaps(packets: Packets, free_from: int, size: int) -> list[tuple[int, int]]:
    left = np.r_[np.int64(free_from), packets.end]
    right = np.r_[packets.offset, np.int64(size)]
    wide = np.flatnonzero(right - left > TIMESTAMP)
    return list(zip(left[wide].tolist(), right[wide].tolist(), strict=True))


def _message_ids(data: Bytes, at: Positions, is_v2: NDArray[np.bool_]) -> NDArray[np.uint32]:
    last = len(data) - 1
    low, middle, high = (data[np.minimum(at + n, last)].astype(np.uint32) for n in (7, 8, 9))
    return np.where(is_v2, low | middle << 8 | high << 16, data[at + 5]).astype(np.uint32)


def find_unknown(data: Bytes, packets: Packets, *, free_from: int, limit: int) -> Packets | None:
    """Return the packets in the gaps between `packets` that are none by our definitions.

    None where there are none.
    """
    places: list[int] = []
    for gap in _gaps(packets, free_from, len(data)):
        places += _walk(data, gap, limit)
    if not places:
        return None
    at = np.array(places, dtype=np.int64)
    is_v2 = data[at] == MAGIC_V2
    length = data[at + 1].astype(np.int64)
    row = message_rows(data, at, is_v2)
    trimmed_late = _is_trimmed_late(data, at, row, is_v2)
    extra = _inferred_extra(data, at, np.where(is_v2, HEADER_V2, HEADER_V1) - 1 + length)
    extra[trimmed_late] = packet_tables().crc_extra[row[trimmed_late]]
    msgid = _message_ids(data, at, is_v2)
    msgid[(row >= 0) & ~trimmed_late] |= OTHER_DEFINITION
    is_at_edge = np.isin(at, np.r_[np.int64(free_from), packets.end])  # so without a time
    sequence_at = at + np.where(is_v2, 4, 2)
    flags = is_v2 * (IS_V2 + IS_SIGNED * (data[at + 2] == SIGNED_FLAG))
    flags += IS_UNKNOWN * ~trimmed_late
    found = Packets(
        offset=at,
        time_us=record_times(data, at, np.where(is_at_edge, at, 0)),
        msgid=msgid,
        system=data[sequence_at + 1],
        component=data[sequence_at + 2],
        sequence=data[sequence_at],
        length=length.astype(np.uint8),
        flags=flags.astype(np.uint8),
        extra=extra.astype(np.uint8),
    )
    return found.take(extra != NO_EXTRA)


def implausible(packets: Packets) -> NDArray[np.bool_]:
    """Return which packets of unknown messages are not to be believed.

    Those whose CRC_EXTRA is not what most packets of that message have; where the log is damaged
    elsewhere, one that is alone: it may be a known message whose id was hit; and those of a known
    message that are few, or disagree: they are damaged.
    """
    wrong = np.zeros(len(packets), dtype=np.bool_)
    unknown = np.flatnonzero(packets.flags & IS_UNKNOWN)
    space = packets.offset[1:] - packets.end[:-1]
    is_damaged = bool(np.any((space != TIMESTAMP) & (space != 0)))
    for msgid in np.unique(packets.msgid[unknown]).tolist():
        rows = unknown[packets.msgid[unknown] == msgid]
        majority = np.bincount(packets.extra[rows]).argmax()
        agree = packets.extra[rows] == majority
        count = np.count_nonzero(agree)
        if msgid & OTHER_DEFINITION:
            doubtful = bool(count < max(MIN_AGREEING, MIN_AGREEING_SHARE * len(rows)))
        else:
            doubtful = bool(is_damaged and count == 1)
        wrong[rows] = ~agree | doubtful
    return wrong
