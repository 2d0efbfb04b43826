"""Every column is what pymavlink decodes, for every message of the dialect and every framing."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.dialect.message_types import message_type
from flightstack.logs.errors import UnknownNameError
from tests.unit.flightstack.logs.made_logs import START_US, packet, record, same

FRAMINGS: dict[str, dict[str, Any]] = {
    "v2": {"version": 2},
    "v2 signed": {"version": 2, "signed": True},
    "v1": {"version": 1},
}


def decoded(raw: bytes) -> Any:
    return mavlink.MAVLink(None).decode(bytearray(raw))


def assert_columns_equal(packets: list[bytes]) -> None:
    log = read_bytes(b"".join(record(START_US + i * 1000, raw) for i, raw in enumerate(packets)))
    theirs = [decoded(raw) for raw in packets]
    assert len(log) == len(theirs)
    assert log.damage.is_clean
    for name in {message.get_type() for message in theirs}:
        table = log[name]
        expected = [m for m in theirs if m.get_type() == name]
        assert table.names == tuple(expected[0].get_fieldnames())
        for field in table.names:
            for ours, message in zip(table[field], expected, strict=True):
                assert same(ours, getattr(message, field)), (name, field)
        assert table.system.tolist() == [m.get_srcSystem() for m in expected]
        assert table.component.tolist() == [m.get_srcComponent() for m in expected]
        assert table.sequence.tolist() == [m.get_seq() for m in expected]


@pytest.mark.parametrize("framing", FRAMINGS)
def test_equals_pymavlink_for_every_message_of_the_dialect(framing: str) -> None:
    options = FRAMINGS[framing]
    rng = np.random.default_rng(7)
    packets = []
    for msgid, definition in sorted(mavlink.mavlink_map.items()):
        if options["version"] == 1 and msgid > 255:
            continue
        size = definition.unpacker.size
        payloads = [rng.bytes(size) for _ in range(3)]
        payloads += [b"\0" * size, b"\xff" * size]
        if options["version"] == 2:
            payloads += [rng.bytes(n).ljust(size, b"\0") for n in {1, size // 2 + 1, size}]
        packets += [packet(msgid, payload, **options) for payload in payloads]
    assert_columns_equal(packets)


@st.composite
def any_packet(draw: st.DrawFn) -> bytes:
    options = FRAMINGS[draw(st.sampled_from(list(FRAMINGS)))]
    ids = [i for i in mavlink.mavlink_map if options["version"] == 2 or i < 256]
    msgid = draw(st.sampled_from(ids))
    size = mavlink.mavlink_map[msgid].unpacker.size
    payload = draw(st.binary(min_size=0, max_size=size)).ljust(size, b"\0")
    byte = st.integers(0, 255)
    return packet(
        msgid,
        payload,
        sequence=draw(byte),
        system=draw(byte),
        component=draw(byte),
        **options,
    )


@settings(max_examples=150, deadline=None)
@given(st.lists(any_packet(), min_size=1, max_size=30))
def test_equals_pymavlink_for_any_mixture_of_packets(packets: list[bytes]) -> None:
    assert_columns_equal(packets)


def test_columns_carry_units_enums_and_bitmasks() -> None:
    heartbeat = message_type(0)
    attitude = message_type(30)
    assert heartbeat is not None
    assert attitude is not None
    assert heartbeat.field("autopilot").enum == "MAV_AUTOPILOT"
    assert heartbeat.field("base_mode").is_bitmask
    assert attitude.field("roll").unit == "rad"
    assert attitude.field("time_boot_ms").unit == "ms"


def test_a_payload_longer_than_its_definition_keeps_the_fields_that_are_known() -> None:
    payload = np.random.default_rng(1).bytes(28) + b"\x07\x08\x09"
    raw = packet(30, payload)
    log = read_bytes(record(START_US, raw))
    assert same(log["ATTITUDE"]["yaw"][0], decoded(raw).yaw)


def test_a_message_that_the_log_does_not_hold_is_an_empty_table() -> None:
    log = read_bytes(record(START_US, packet(0, b"\1" * 9)))
    assert len(log["ATTITUDE"]) == 0
    assert log["ATTITUDE"]["roll"].dtype == np.float32


def test_unknown_names_say_what_was_meant() -> None:
    log = read_bytes(record(START_US, packet(0, b"\1" * 9)))
    with pytest.raises(UnknownNameError, match="did you mean ATTITUDE"):
        log["ATITUDE"]
    with pytest.raises(UnknownNameError, match="did you mean autopilot"):
        log["HEARTBEAT"]["autopilott"]


def test_unknown_messages_are_kept_raw() -> None:
    packets = [packet(54321, bytes([i, 2, 3]), sequence=i, extra=99) for i in range(1, 6)]
    log = read_bytes(b"".join(record(START_US, raw) for raw in packets))
    assert log.counts == {"UNKNOWN_54321": 5}
    assert log.payloads("UNKNOWN_54321") == [bytes([i, 2, 3]) for i in range(1, 6)]


def test_selection_by_type_source_and_time_decodes_nothing_else() -> None:
    packets = [packet(30, b"\1" * 28, system=1 + i % 2, sequence=i) for i in range(20)]
    packets += [packet(0, b"\1" * 9, system=1, sequence=20)]
    log = read_bytes(b"".join(record(START_US + i * 1000, raw) for i, raw in enumerate(packets)))
    part = log.select(types=["ATT*"], system=2, start_us=START_US + 3000, end_us=START_US + 9000)
    assert part.time_us.tolist() == [START_US + 1000 * i for i in (3, 5, 7)]
    assert part.counts == {"ATTITUDE": 3}
    assert len(part["HEARTBEAT"]) == 0
