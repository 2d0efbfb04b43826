"""Make tlogs byte by byte, and read them with pymavlink to compare with."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as mavlink

START_US = 1_700_000_000_000_000


def packet(
    msgid: int,
    payload: bytes,
    *,
    sequence: int = 0,
    system: int = 1,
    component: int = 1,
    version: int = 2,
    signed: bool = False,
    extra: int | None = None,
) -> bytes:
    """Return one packet, whatever the message; a signature is made up."""
    if version == 1:
        head = struct.pack("<BBBBBB", 0xFE, len(payload), sequence, system, component, msgid)
    else:
        while len(payload) > 1 and payload[-1] == 0:
            payload = payload[:-1]
        ids = (msgid & 0xFFFF, msgid >> 16)
        head = struct.pack(
            "<BBBBBBBHB", 0xFD, len(payload), int(signed), 0, sequence, system, component, *ids
        )
    known = mavlink.mavlink_map.get(msgid)
    crc_extra = extra if extra is not None else known.crc_extra
    crc = mavlink.x25crc(head[1:] + payload + bytes([crc_extra])).crc
    return head + payload + struct.pack("<H", crc) + (bytes(range(13)) if signed else b"")


def record(time_us: int, raw: bytes) -> bytes:
    return struct.pack(">Q", time_us) + raw


def random_packets(count: int, seed: int, **options: Any) -> list[bytes]:
    """Return packets of random types with random payloads, sequence numbers counting up."""
    rng = np.random.default_rng(seed)
    ids = sorted(mavlink.mavlink_map)
    version = options.get("version", 2)
    ids = [i for i in ids if version == 2 or i < 256]
    made = []
    for index in range(count):
        msgid = int(rng.choice(ids))
        size = mavlink.mavlink_map[msgid].unpacker.size
        payload = rng.bytes(size)
        if version == 2 and rng.random() < 0.3:
            payload = payload[: int(rng.integers(1, size + 1))].ljust(size, b"\0")
        made.append(packet(msgid, payload, sequence=index % 256, **options))
    return made


def flight_messages(count: int, seed: int = 1) -> list[Any]:
    """Return messages like a vehicle's, small and frequent."""
    rng = np.random.default_rng(seed)
    made: list[Any] = []
    for index in range(count):
        ms = index * 20
        a, b, c, d, e, f = rng.normal(size=6).tolist()
        match index % 5:
            case 0 | 1:
                made.append(mavlink.MAVLink_attitude_message(ms, a, b, c, d, e, f))
            case 2:
                made.append(mavlink.MAVLink_local_position_ned_message(ms, a, b, c, d, e, f))
            case 3:
                made.append(mavlink.MAVLink_vfr_hud_message(a, b, 9, 50, c, d))
            case _:
                made.append(mavlink.MAVLink_heartbeat_message(2, 12, 81, 65536, 3, 3))
    return made


def tlog(messages: list[Any], *, step_us: int = 20_000, system: int = 1) -> bytes:
    """Return the messages as a tlog of one sender."""
    sender = mavlink.MAVLink(None, system, 1)
    raw = b""
    parts = []
    for index, message in enumerate(messages):
        raw = message.pack(sender)
        sender.seq = (sender.seq + 1) % 256
        parts.append(record(START_US + index * step_us, raw))
    return b"".join(parts)


def pymavlink_messages(path: Path) -> Iterator[Any]:
    """Yield what pymavlink finds in a tlog, packets that are damaged or unknown left out."""
    connection = mavutil.mavlogfile(str(path), robust_parsing=True)
    connection.mav = mavlink.MAVLink(None)
    connection.mav.robust_parsing = True
    while (message := connection.recv_msg()) is not None:
        if message.get_type() != "BAD_DATA" and not message.get_type().startswith("UNKNOWN"):
            yield message
    connection.close()


def same(ours: Any, theirs: Any) -> bool:
    """Return whether a column's value is what pymavlink decoded, NaN and all."""
    if isinstance(theirs, str):
        return bool(ours == theirs)
    return bool(np.array_equal(np.asarray(ours), np.asarray(theirs), equal_nan=True))
