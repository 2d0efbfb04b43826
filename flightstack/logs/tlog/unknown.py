"""Find packets whose message is in no definition, and check them all the same.

Their CRC_EXTRA is not known, but only one byte can make a checksum hold, for one in 256 wrong
checksums none can, and it must be the same byte for every packet of that message. Candidates are
taken only where they fill a gap between packets, record after record.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import packet_tables
from flightstack.logs.tlog import crc
from flightstack.logs.tlog.packet_search import record_times
from flightstack.logs.tlog.packets import (
    HEADER_V1,
    HEADER_V2,
    IS_SIGNED,
    IS_UNKNOWN,
    IS_V2,
    MAGIC_V2,
    SIGNED_FLAG,
    TIMESTAMP,
    Packets,
    packet_length,
)

NO_EXTRA = -1


@cache
def _known_ids() -> frozenset[int]:
    return frozenset(packet_tables().ids.tolist())


@cache
def _byte_of_state() -> NDArray[np.int16]:
    table = np.full(1 << 16, NO_EXTRA, dtype=np.int16)
    table[crc.byte_table()] = np.arange(256)
    return table


def _unknown_end(data: NDArray[np.uint8], at: int) -> int:
    """Return where a packet of an unknown message at `at` ends, -1 where there is none."""
    if at + HEADER_V2 > len(data):
        return -1
    head = data[at : at + HEADER_V2]
    length = packet_length(head)
    id_bytes = head[7:10] if head[0] == MAGIC_V2 else head[5:6]
    is_known = int.from_bytes(id_bytes.tobytes(), "little") in _known_ids()
    return -1 if not length or is_known or at + length > len(data) else at + length


def _walk(data: NDArray[np.uint8], gap: tuple[int, int], limit: int) -> list[int]:
    """Return the positions of packets that fill a gap record by record, from its left edge."""
    left, right = gap
    found: list[int] = []
    edge = left
    while edge + TIMESTAMP < right:
        at = edge + TIMESTAMP
        end = _unknown_end(data, at)
        if end < 0:
            at, end = edge, _unknown_end(data, edge)
        if end < 0 or end > right:
            break
        if at >= limit:
            return found
        found.append(at)
        edge = end
    fills_gap = edge in (right, right - TIMESTAMP)
    return found if fills_gap else found[:-1]


def _inferred_extra(
    data: NDArray[np.uint8], at: NDArray[np.int64], length: NDArray[np.int64]
) -> NDArray[np.int16]:
    """Return the one byte that makes each checksum hold, NO_EXTRA where none does."""
    state = crc.checksums(data, at + 1, length)
    check_at = at + 1 + length
    stored = data[check_at].astype(np.uint16) | data[check_at + 1].astype(np.uint16) << 8
    needed = _byte_of_state()[stored ^ state >> 8]
    return np.where(needed == NO_EXTRA, NO_EXTRA, needed ^ (state & 0xFF)).astype(np.int16)


def _gaps(packets: Packets, free_from: int, size: int) -> list[tuple[int, int]]:
    left = np.r_[np.int64(free_from), packets.end]
    right = np.r_[packets.offset, np.int64(size)]
    wide = np.flatnonzero(right - left > TIMESTAMP)
    return list(zip(left[wide].tolist(), right[wide].tolist(), strict=True))


def find_unknown(
    data: NDArray[np.uint8], packets: Packets, *, free_from: int, limit: int
) -> Packets | None:
    """Return the packets of unknown messages in the gaps between `packets`, None where none are."""
    places: list[int] = []
    for gap in _gaps(packets, free_from, len(data)):
        places += _walk(data, gap, limit)
    if not places:
        return None
    at = np.array(places, dtype=np.int64)
    is_v2 = data[at] == MAGIC_V2
    header = np.where(is_v2, HEADER_V2, HEADER_V1)
    length = data[at + 1].astype(np.int64)
    extra = _inferred_extra(data, at, header - 1 + length)
    wide_id = (
        data[at + 7] | data[at + 8].astype(np.uint32) << 8 | data[at + 9].astype(np.uint32) << 16
    )
    is_at_edge = np.isin(at, np.r_[np.int64(free_from), packets.end])  # so without a time
    sequence_at = at + np.where(is_v2, 4, 2)
    flags = IS_UNKNOWN + is_v2 * (IS_V2 + IS_SIGNED * (data[at + 2] == SIGNED_FLAG))
    found = Packets(
        offset=at,
        time_us=record_times(data, at, np.where(is_at_edge, at, 0)),
        msgid=np.where(is_v2, wide_id, data[at + 5]).astype(np.uint32),
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

    Those whose CRC_EXTRA is not what most packets of that message have; and, where the log is
    damaged elsewhere, one that is alone: it may be a known message whose id was hit.
    """
    wrong = np.zeros(len(packets), dtype=np.bool_)
    unknown = np.flatnonzero(packets.flags & IS_UNKNOWN)
    space = packets.offset[1:] - packets.end[:-1]
    is_damaged = bool(np.any((space != TIMESTAMP) & (space != 0)))
    for msgid in np.unique(packets.msgid[unknown]).tolist():
        rows = unknown[packets.msgid[unknown] == msgid]
        majority = np.bincount(packets.extra[rows]).argmax()
        agree = packets.extra[rows] == majority
        wrong[rows] = ~agree | (is_damaged and np.count_nonzero(agree) == 1)
    return wrong
