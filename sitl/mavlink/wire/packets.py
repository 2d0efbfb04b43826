"""Turn messages into MAVLink 2 packets, and datagrams of any content into messages.

A message's payload is packed once and wrapped for each link with that link's own sequence number.
"""

import operator
import struct
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from pymavlink.generator import mavcrc

from sitl.mavlink.wire.dialect import Message, mavlink

MAGIC_V1, MAGIC_V2 = 0xFE, 0xFD
HEADER_V1, HEADER_V2 = 6, 10  # bytes
START = bytes((MAGIC_V2,))
HEADER = struct.Struct("<BBBBBBHB")  # after the start; the 24-bit message id as 16 + 8
EXTRAS = tuple(bytes((extra,)) for extra in range(256))  # CRC_EXTRA as the checksum takes it
CHECKSUM = struct.Struct("<H")
SIGNED = 0x01  # the one incompatibility flag that is defined
SIGNATURE_BYTES = 13
SHORTEST_BYTES = 8  # MAVLink 1 without payload
MAX_BAD_PACKETS = 8  # in one datagram or piece; what follows is dropped


class Packed(NamedTuple):
    """A message ready to be wrapped in a packet."""

    message_id: int
    payload: bytes  # trailing zeros removed
    crc_extra: int


class Received(NamedTuple):
    """A message that came in, with the packet it came in."""

    message_id: int  # not `message.id`: a field of that name hides it in some messages
    message: Message
    raw: bytes
    system: int
    component: int

    @property
    def is_signed(self) -> bool:
        """Whether the packet carries a signature, good or bad."""
        return self.raw[0] == MAGIC_V2 and bool(self.raw[2] & SIGNED)


_codec = mavlink.MAVLink(None)  # stateless as used here: no key, sequence numbers ignored


def pack(message: Message) -> Packed:
    """Serialise a message's payload."""
    payload = _serialiser(message.__class__)(message)
    return Packed(message.get_msgId(), payload.rstrip(b"\0") or b"\0", message.crc_extra)


def wrap(
    packed: Packed, *, sequence: int, system: int, component: int, is_signed: bool = False
) -> bytes:
    """Make a packet: add header and checksum; a signature is still to follow."""
    message_id, payload, crc_extra = packed
    flags = SIGNED if is_signed else 0
    low, high = message_id & 0xFFFF, message_id >> 16
    body = HEADER.pack(len(payload), flags, 0, sequence, system, component, low, high) + payload
    return START + body + CHECKSUM.pack(_checksum(body + EXTRAS[crc_extra]))


def split(datagram: bytes) -> list[Received]:
    """Find the valid packets of known messages in a datagram; never raises."""
    return _split(datagram, is_stream=False)[0]


def split_stream(data: bytes) -> tuple[list[Received], bytes]:
    """Find the valid packets in a piece of a stream; what may be the beginning of one is left."""
    return _split(data, is_stream=True)


def _split(data: bytes, *, is_stream: bool) -> tuple[list[Received], bytes]:
    received: list[Received] = []
    position = bad = 0
    while bad < MAX_BAD_PACKETS:
        position = _next_magic(data, position)
        if position < 0:
            break
        if is_stream and len(data) - position < _packet_bytes(data, position):
            return received, data[position:]
        raw = _candidate(data, position)
        item = _decode(raw) if raw is not None else None
        if raw is None or item is None:
            bad += 1
            position += 1
            continue
        position += len(raw)
        if item.message is not None:  # None: of a type that nobody knows
            received.append(item)
    return received, b""


def _next_magic(data: bytes, start: int) -> int:
    places = [p for p in (data.find(MAGIC_V2, start), data.find(MAGIC_V1, start)) if p >= 0]
    return min(places, default=-1)


def _candidate(data: bytes, start: int) -> bytes | None:
    """Cut out the packet that would begin at `start`; None if it cannot be one."""
    end = start + _packet_bytes(data, start)
    is_v2 = data[start] == MAGIC_V2
    if end > len(data) or (is_v2 and data[start + 2] & ~SIGNED):
        return None
    return data[start:end]


def _packet_bytes(data: bytes, start: int) -> int:
    """Say how long the packet that would begin at `start` is, or at least is."""
    if len(data) - start < SHORTEST_BYTES:
        return SHORTEST_BYTES
    if data[start] == MAGIC_V1:
        return data[start + 1] + 8
    return data[start + 1] + 12 + (SIGNATURE_BYTES if data[start + 2] & SIGNED else 0)


def _decode(raw: bytes) -> Received | None:
    """Read a packet that is as long as it says; None if its checksum is wrong."""
    if raw[0] == MAGIC_V1:
        begin, system, component, message_id = HEADER_V1, raw[3], raw[4], raw[5]
    else:
        begin, system, component = HEADER_V2, raw[5], raw[6]
        message_id = raw[7] | raw[8] << 8 | raw[9] << 16
    message_type = mavlink.mavlink_map.get(message_id)
    if message_type is None:
        return Received(message_id, None, raw, system, component)
    end = begin + raw[1]
    if _checksum(raw[1:end] + bytes((message_type.crc_extra,))) != raw[end] | raw[end + 1] << 8:
        return None
    return Received(message_id, _deserialiser(message_type)(raw[begin:end]), raw, system, component)


def _checksum_slowly(data: bytes) -> int:
    return int(mavcrc.x25crc(data).crc)


_checksum: Callable[[bytes], int] = mavcrc.mcrf4xx or _checksum_slowly  # fastcrc, if it is there


@cache
def _serialiser(message_type: Any) -> Callable[[Message], bytes]:
    """Choose how to pack a type: as fast as its fields allow, its own way if it has text."""
    pack_values = message_type.unpacker.pack
    names = message_type.ordered_fieldnames
    if "char" in message_type.fieldtypes or len(names) == 1:
        return _pack_slowly
    fields = operator.attrgetter(*names)
    if not any(message_type.array_lengths):
        return lambda message: bytes(pack_values(*fields(message)))
    arrays = [length > 0 for length in message_type.array_lengths]

    def pack_arrays(message: Message) -> bytes:
        values: list[float] = []
        for value, is_array in zip(fields(message), arrays, strict=True):
            if is_array:
                values.extend(value)
            else:
                values.append(value)
        return bytes(pack_values(*values))

    return pack_arrays


@cache
def _deserialiser(message_type: Any) -> Callable[[bytes], Message]:
    """Make what reads a type's payload, which MAVLink 2 cuts short and newer senders lengthen."""
    unpack, size = message_type.unpacker.unpack, message_type.unpacker.size
    lengths = message_type.lengths
    places = [(sum(lengths[:order]), lengths[order]) for order in message_type.orders]

    def deserialise(payload: bytes) -> Message:
        values = unpack(payload[:size].ljust(size, b"\0"))
        fields = [
            values[at] if length == 1 else list(values[at : at + length]) for at, length in places
        ]
        if "char" in message_type.fieldtypes:
            fields = [f.rstrip(b"\0") if isinstance(f, bytes) else f for f in fields]
        return message_type(*fields)

    return deserialise


def _pack_slowly(message: Message) -> bytes:
    message.pack(_codec)
    return bytes(message.get_payload())
