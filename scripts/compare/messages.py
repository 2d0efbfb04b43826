"""MAVLink 2 messages as raw bytes: cut from datagrams or a tlog, decoded only where they differ."""

import functools
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import development as mavlink

VEHICLE_COMPONENTS = ("/1", "/25", "/100")
MAGIC, HEADER_BYTES, CHECKSUM_BYTES = 0xFD, 10, 2
SIGNED, SIGNATURE_BYTES = 1, 13  # a bit of the incompatibility flags
TLOG_STAMP_BYTES = 8
SEQUENCE, PAYLOAD = "(sequence number)", "(payload)"  # among the fields of a message
IMAGE, ENDING = -1, -2  # kinds that are not MAVLink's: their payload is JSON
NAMES = {IMAGE: "IMAGE", ENDING: "ENDING"}
ATTITUDE, HEARTBEAT, CAMERA_TRIGGER = (
    mavlink.MAVLINK_MSG_ID_ATTITUDE,
    mavlink.MAVLINK_MSG_ID_HEARTBEAT,
    mavlink.MAVLINK_MSG_ID_CAMERA_TRIGGER,
)


class Message(NamedTuple):
    """One message of a flight."""

    source: str  # link and component
    kind: int  # MAVLink's message id
    payload: bytes
    step: int = 0  # from the sequence number before it, of the same source
    packet: bytes = b""

    @property
    def name(self) -> str:
        """Source and type."""
        return _name(self.source, self.kind)

    def fields(self) -> dict[str, Any]:
        """Decode it."""
        fields: dict[str, Any] = {SEQUENCE: self.step}
        if self.kind in NAMES:
            return {**fields, **json.loads(self.payload)}
        try:
            decoded = mavlink.MAVLink(None).decode(bytearray(self.packet))
        except mavlink.MAVError:  # newer than this dialect
            return fields | {PAYLOAD: self.payload.hex()}
        return fields | {name: getattr(decoded, name) for name in decoded.get_fieldnames()}


@functools.cache
def _name(source: str, kind: int) -> str:
    known = mavlink.mavlink_map.get(kind)
    return f"{source} {NAMES.get(kind, f'#{kind}') if known is None else known.msgname}"


class Reader:
    """Cuts packets out of what comes in, and follows the sequence numbers of each source."""

    def __init__(self) -> None:
        self._last: dict[str, int] = {}

    def read(self, data: bytes, link: str) -> Iterator[Message]:
        """Give the messages of a datagram."""
        start = 0
        while start < len(data):
            if data[start] != MAGIC:
                raise ValueError(f"no MAVLink 2 on {link}: {data[start:].hex()}")
            size = packet_size(data, start)
            yield self._message(data[start : start + size], link)
            start += size

    def _message(self, packet: bytes, link: str) -> Message:
        source = f"{link} {packet[5]}/{packet[6]}"
        sequence = packet[4]
        step = (sequence - self._last.get(source, sequence - 1)) % 256
        self._last[source] = sequence
        kind = int.from_bytes(packet[7:10], "little")
        payload = packet[HEADER_BYTES : HEADER_BYTES + packet[1]]
        return Message(source, kind, payload, step, packet)


def read_tlog(path: Path, link: str) -> Iterator[Message]:
    """Give the messages of a tlog, without its stamps."""
    data, reader, start = path.read_bytes(), Reader(), 0
    while start + TLOG_STAMP_BYTES + HEADER_BYTES <= len(data):
        start += TLOG_STAMP_BYTES
        size = packet_size(data, start)
        yield from reader.read(data[start : start + size], link)
        start += size


def packet_size(data: bytes, start: int) -> int:
    """How many bytes the packet has that begins there."""
    size = HEADER_BYTES + data[start + 1] + CHECKSUM_BYTES
    return size + (SIGNATURE_BYTES if data[start + 2] & SIGNED else 0)


def without_repeated_heartbeats(messages: list[Message]) -> list[Message]:
    """Drop what a vehicle says once a second of wall time while it awaits an answer."""
    kept, standing = [], set[str]()  # links on which an image was announced, and nothing since
    for message in messages:
        link, _, sender = message.source.partition(" ")
        if message.kind == CAMERA_TRIGGER:
            standing.add(link)
        elif message.kind == ATTITUDE:
            standing.discard(link)
        is_beat = message.kind == HEARTBEAT and sender.endswith(VEHICLE_COMPONENTS)
        if not (is_beat and link in standing):
            kept.append(message)
    return kept


def image_message(stamp: str, sequence: str, data: bytes) -> Message:
    """Let a camera image be a message, too."""
    digest = hashlib.sha256(data).hexdigest()
    return _told("camera", IMAGE, {"stamp": stamp, "sequence": sequence, "sha256": digest})


def ending_message(process: str, exit_code: int, result: Mapping[str, Any]) -> Message:
    """Let what a process says at its end be a message, too."""
    return _told(process, ENDING, {"exit_code": exit_code, **result})


def _told(source: str, kind: int, values: Mapping[str, Any]) -> Message:
    return Message(source, kind, json.dumps(values).encode())
