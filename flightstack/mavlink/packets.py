"""Cut bytes into MAVLink packets, without decoding them.

A packet whose message is known must have a right checksum; one that is unknown to the dialect is
taken by its header if another packet, or nothing, follows it. On any doubt the search goes on at
the next byte, so that noise costs no more than the packets it hit.
"""

import re

from pymavlink.dialects.v20 import common
from pymavlink.generator.mavcrc import mcrf4xx

from flightstack.mavlink_numbers import (
    CHECKSUM_BYTES,
    CRC_START,
    HEADER_V1,
    HEADER_V2,
    MAGIC_V1,
    MAGIC_V2,
    SIGNATURE_BYTES,
    SIGNED_FLAG,
)

STAMP_BYTES = 4
OVERHEAD_V1 = HEADER_V1 + CHECKSUM_BYTES
OVERHEAD_V2 = HEADER_V2 + CHECKSUM_BYTES
BEGINNINGS = (MAGIC_V2, MAGIC_V1)
BEGINNING = re.compile(rb"[\xfd\xfe]")
CRC_EXTRA = {number: bytes([kind.crc_extra]) for number, kind in common.mavlink_map.items()}


def split_packets(data: bytes, max_unsound: int | None = None) -> tuple[list[bytes], int]:
    """Return the whole packets in `data`, and how many of its bytes are done with.

    After `max_unsound` beginnings of packets that were none, what follows is noise, too.
    """
    packets = []
    at, end, unsound = 0, len(data), 0
    while (at := _next_beginning(data, at)) < end and unsound != max_unsound:
        length = _packet_length(data, at, end)
        if at + length > end:
            break  # not all here yet
        packet = data[at : at + length]
        if _is_sound(packet, data, at + length):
            packets.append(packet)
            at += length
        else:
            at += 1
            unsound += 1
    return packets, at


def _next_beginning(data: bytes, at: int) -> int:
    """Find the next byte that a packet may begin with; the end of the data if there is none."""
    if at < len(data) and data[at] in BEGINNINGS:
        return at
    found = BEGINNING.search(data, at)
    return len(data) if found is None else found.start()


class PacketSplitter:
    """Cut a byte stream whose reads end anywhere, as TCP and serial lines deliver it."""

    def __init__(self) -> None:
        self._rest = b""

    def split(self, data: bytes) -> list[bytes]:
        """Return the packets that `data` completes; keep what is unfinished."""
        data = self._rest + data
        packets, used = split_packets(data)
        self._rest = data[used:]
        return packets


def message_id(packet: bytes) -> int:
    """Read the message id of a whole packet."""
    if packet[0] == MAGIC_V2:
        return packet[7] | packet[8] << 8 | packet[9] << 16
    return packet[5]


def source_of(packet: bytes) -> tuple[int, int]:
    """Read the system and component that sent a whole packet."""
    return (packet[5], packet[6]) if packet[0] == MAGIC_V2 else (packet[3], packet[4])


def identify(packet: bytes) -> tuple[int, int, int]:
    """Read message id, system and component of a whole packet, in one go."""
    if packet[0] == MAGIC_V2:
        return packet[7] | packet[8] << 8 | packet[9] << 16, packet[5], packet[6]
    return packet[5], packet[3], packet[4]


def boot_time_us(packet: bytes) -> int:
    """Return the time since boot with which a packet's message begins (time_boot_ms)."""
    begin = HEADER_V2 if packet[0] == MAGIC_V2 else HEADER_V1
    end = begin + min(packet[1], STAMP_BYTES)  # MAVLink 2 leaves trailing zeros out
    return int.from_bytes(packet[begin:end], "little") * 1000


def is_signed(packet: bytes) -> bool:
    """Whether a whole packet ends in a signature, whoever made it."""
    return packet[0] == MAGIC_V2 and bool(packet[2] & SIGNED_FLAG)


def checksum(packet: bytes) -> int:
    """Compute the checksum of a packet whose message the dialect knows; more may follow it."""
    end = packet[1] + (HEADER_V2 if packet[0] == MAGIC_V2 else HEADER_V1)
    value: int = mcrf4xx(packet[1:end] + CRC_EXTRA[message_id(packet)], CRC_START)
    return value


def _packet_length(data: bytes, at: int, end: int) -> int:
    """Read how long the packet at `at` is, or at least how much of it is needed to know."""
    if at + OVERHEAD_V1 > end:
        return OVERHEAD_V1
    if data[at] == MAGIC_V1:
        return data[at + 1] + OVERHEAD_V1
    if data[at + 2] & SIGNED_FLAG:
        return data[at + 1] + OVERHEAD_V2 + SIGNATURE_BYTES
    return data[at + 1] + OVERHEAD_V2


def _is_sound(packet: bytes, data: bytes, following: int) -> bool:
    extra = CRC_EXTRA.get(message_id(packet))
    if extra is None:
        return following == len(data) or data[following] in (MAGIC_V1, MAGIC_V2)
    end = packet[1] + (HEADER_V2 if packet[0] == MAGIC_V2 else HEADER_V1)
    found: int = mcrf4xx(packet[1:end] + extra, CRC_START)
    return found == packet[end] | packet[end + 1] << 8
