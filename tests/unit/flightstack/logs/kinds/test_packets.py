"""Everything readable is read: packets that another sender made in a way of its own."""

import struct
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.facts.summary import summarise
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.kinds.made_vehicles import Sender, Vehicle, entries, tlog
from tests.unit.flightstack.logs.made_logs import START_US, packet, record

GREW = {  # messages with extensions, and their length before
    "SCALED_PRESSURE": (29, 14),
    "GPS_RAW_INT": (24, 30),
    "BATTERY_STATUS": (147, 36),
    "SCALED_IMU": (26, 22),
    "DISTANCE_SENSOR": (132, 14),
}


def whole_payload(size: int) -> bytes:
    return bytes(range(1, size + 1))


@pytest.mark.parametrize("name", GREW)
@pytest.mark.parametrize("between", [b"", b"\xfe\x1c" + bytes(20)])
def test_version_1_packets_of_messages_that_grew_stand_alone(name: str, between: bytes) -> None:
    msgid, size = GREW[name]
    one = packet(msgid, whole_payload(size), version=1)
    assert read_bytes(one).counts == {name: 1}
    log = read_bytes((one + between) * 9)
    assert log.counts == {name: 9}


def trimmed_late(message: Any, sequence: int) -> bytes:
    """Return a packet whose checksum was made before its trailing zeros were trimmed."""
    sender = Sender(component=194)
    sender.link.seq = sequence
    kept = sender.pack(message)
    header, payload = kept[:10], kept[10:-2]
    full = payload.ljust(mavlink.mavlink_map[message.get_msgId()].unpacker.size, b"\0")
    summed = bytes([len(full)]) + header[2:] + full + bytes([message.crc_extra])
    return kept[:-2] + struct.pack("<H", mavlink.x25crc(summed).crc)


@pytest.mark.parametrize(
    "message",
    [
        mavlink.MAVLink_distance_sensor_message(5, 20, 500, 90, 1, 25, 0, 0),
        mavlink.MAVLink_vfr_hud_message(0, 0, 0, 0, 0, 0),
        mavlink.MAVLink_servo_output_raw_message(9, 0, 1500, 1500, 0, 0, 0, 0, 0, 0),
    ],
)
def test_checksums_of_untrimmed_packets_hold(message: Any) -> None:
    rows = entries(Vehicle())
    own = [(START_US + n * 400_000 + 7, trimmed_late(message, n % 256)) for n in range(140)]
    own += [(START_US + 9, own[0][1]), (START_US + 11, own[0][1])]  # one after another
    log = read_bytes(tlog(rows + own))
    assert log.counts[message.get_type()] == len(own)
    assert not log.damage.regions
    field = message.get_fieldnames()[0]
    assert set(log[message.get_type()][field].tolist()) == {getattr(message, field)}


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("msgid", [66, 142, 69])
def test_a_known_message_under_another_definition_is_kept_raw(msgid: int, version: int) -> None:
    extra = (mavlink.mavlink_map[msgid].crc_extra + 91) % 256
    payloads = [struct.pack("<BHH", n % 9 + 1, n, 77) + b"\x01" for n in range(66)]
    strange = [
        packet(
            msgid, payload, sequence=n % 256, system=255, component=3, version=version, extra=extra
        )
        for n, payload in enumerate(payloads)
    ]
    rows = [(START_US + n * 900_000 + 5, raw) for n, raw in enumerate(strange)]
    log = read_bytes(tlog(entries(Vehicle()) + rows))
    assert not log.damage.regions
    assert log.payloads(f"UNKNOWN_{msgid}") == payloads
    assert mavlink.mavlink_map[msgid].msgname not in log
    assert all(loss.lost == 0 for loss in log.losses)
    part = log.select(types=["UNKNOWN_*"])
    assert part.counts == {f"UNKNOWN_{msgid}": 66}


def test_damaged_packets_of_a_known_message_are_no_other_definition() -> None:
    rows = entries(Vehicle())
    rng = np.random.default_rng(2)
    hit = []
    for time_us, raw in rows:
        is_hit = rng.random() < 0.1 and len(raw) > 20
        hit.append((time_us, raw[:14] + bytes([raw[14] ^ 0x5A]) + raw[15:] if is_hit else raw))
    log = read_bytes(tlog(hit))
    assert not [name for name in log.counts if name.startswith("UNKNOWN")]
    assert len(log.damage.regions) > 50


def test_what_was_read_well_is_still_read_well() -> None:
    rows = entries(Vehicle())
    zero_tail = read_bytes(tlog(rows) + bytes(4096))
    assert len(zero_tail) == len(rows)
    fixed_length = b"".join(record(time_us, raw.ljust(263, b"\0")) for time_us, raw in rows)
    log = read_bytes(fixed_length)
    assert len(log) == len(rows)
    assert summarise(Flight(log), [])["flights"] == 1
    start_bytes = [
        (0x0005_FE00_FD00_0000 + n * 0x100, raw) for n, (_, raw) in enumerate(rows[:300])
    ]
    assert len(read_bytes(tlog(start_bytes))) == 300
    same_stamp = read_bytes(tlog([(START_US, raw) for _, raw in rows[:40]]))
    assert len(same_stamp) == 40
    assert set(same_stamp.time_us.tolist()) == {START_US}
