"""Turn bytes that a fuzzer has made into MAVLink packets whose checksums are right.

A fuzzer would find a right checksum once in 65,536 inputs, and then only reach the parsers. Input
is read as records: which message (1 byte, of a list), component and version (1), length (1),
payload.
"""

import struct
from collections.abc import Iterator, Sequence
from typing import Any

from pymavlink.generator.mavcrc import mcrf4xx

CRC_START = 0xFFFF
V1_BIT = 0x80  # of the second byte; the others choose the component


def packets_of(
    data: bytes, kinds: Sequence[Any], *, system: int, components: Sequence[int], target: int = 0
) -> Iterator[bytes]:
    """Give the packets that the bytes stand for.

    `kinds` are pymavlink's classes of messages, `components` who sends. With a `target` system, the
    messages that have one are addressed to its autopilot.
    """
    at = 0
    while at + 3 <= len(data):
        kind = kinds[data[at] % len(kinds)]
        choice, size = data[at + 1], data[at + 2]
        payload = bytearray(data[at + 3 : at + 3 + size])
        at += 3 + size
        if target:
            payload = payload.ljust(kind.unpacker.size, b"\0")[:255]
            _address(payload, kind, target)
        component = components[(choice & ~V1_BIT) % len(components)]
        is_v1 = bool(choice & V1_BIT) and kind.id < 256
        yield packet(kind, bytes(payload), (system, component), is_v1=is_v1)


def packet(kind: Any, payload: bytes, source: tuple[int, int], *, is_v1: bool = False) -> bytes:
    """Wrap a payload of any length."""
    if is_v1:
        body = struct.pack("<BBBBB", len(payload), 0, *source, kind.id)
    else:
        low, high = kind.id & 0xFFFF, kind.id >> 16
        body = struct.pack("<BBBBBBHB", len(payload), 0, 0, 0, *source, low, high)
    body += payload
    checksum = mcrf4xx(body + bytes((kind.crc_extra,)), CRC_START)
    return (b"\xfe" if is_v1 else b"\xfd") + body + struct.pack("<H", checksum)


def _address(payload: bytearray, kind: Any, system: int) -> None:
    for field, value in (("target_system", system), ("target_component", 1)):
        if field in kind.fieldnames:
            payload[_place(kind, field)] = value


def _place(kind: Any, field: str) -> int:
    """Say where a one-byte field stands in a payload."""
    codes = zip(kind.native_format.decode()[1:], kind.array_lengths, strict=True)
    sizes = [struct.calcsize(f"<{code}") * max(1, count) for code, count in codes]
    return sum(sizes[: kind.ordered_fieldnames.index(field)])
