from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.view import View
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import MAX_BAD_PACKETS, Packed, Received, pack, split, wrap
from tests.unit.sitl.mavlink.fakes import FakeVehicle


def wrapped(message: object, **header: Any) -> bytes:
    values = {"sequence": 0, "system": 1, "component": 1} | header
    return wrap(pack(message), **values)


def sequence_of(item: Received) -> int:
    return item.raw[4]


HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 12, 29, 0x03040000, 3, 3)


@pytest.mark.parametrize("message_id", sorted(ENCODERS))
def test_packets_are_those_that_pymavlink_makes(message_id: int) -> None:
    message = ENCODERS[message_id](View(FakeVehicle()))
    assert message is not None
    peer = mavlink.MAVLink(None, srcSystem=7, srcComponent=25)
    peer.seq = 200
    assert wrapped(message, sequence=200, system=7, component=25) == message.pack(peer)


@pytest.mark.parametrize("message_id", sorted(mavlink.mavlink_map))
def test_messages_are_those_that_pymavlink_reads(message_id: int) -> None:
    message_type = mavlink.mavlink_map[message_id]
    whole = message_type.unpacker.size
    rng = np.random.default_rng(message_id)
    for length in {1, whole // 2 or 1, whole, min(255, whole + 3)}:  # a newer sender knows more
        packed = Packed(message_type.id, rng.bytes(length), message_type.crc_extra)
        raw = wrap(packed, sequence=0, system=1, component=1)
        signed = wrap(packed, sequence=0, system=1, component=1, is_signed=True) + bytes(13)
        for sent in (raw, signed):
            (received,) = split(sent)
            theirs = mavlink.MAVLink(None).decode(bytearray(sent))
            assert type(received.message) is type(theirs)
            assert repr(received.message.to_dict()) == repr(theirs.to_dict())  # NaN equals NaN


def test_a_datagram_may_hold_several_packets_and_noise_between() -> None:
    datagram = b"noise" + wrapped(HEARTBEAT, sequence=1) + b"\x00" + wrapped(HEARTBEAT, sequence=2)
    received = split(datagram)
    assert [sequence_of(item) for item in received] == [1, 2]
    assert received[0].raw == wrapped(HEARTBEAT, sequence=1)


def test_a_damaged_packet_is_dropped_and_the_next_is_found() -> None:
    damaged = bytearray(wrapped(HEARTBEAT))
    damaged[12] ^= 0x40
    received = split(bytes(damaged) + wrapped(HEARTBEAT, sequence=9))
    assert [sequence_of(item) for item in received] == [9]


def test_mavlink_1_is_understood() -> None:
    peer = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    (received,) = split(HEARTBEAT.pack(peer, force_mavlink1=True))
    assert (received.system, received.component, received.message_id) == (255, 190, 0)


def test_a_signature_is_accepted_and_kept_in_the_raw_packet() -> None:
    peer = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    peer.signing.secret_key = bytes(32)
    peer.signing.sign_outgoing = True
    raw = HEARTBEAT.pack(peer)
    (received,) = split(raw)
    assert received.raw == raw
    assert len(raw) == len(wrapped(HEARTBEAT)) + 13


def test_unknown_incompatibility_flags_are_refused() -> None:
    raw = bytearray(wrapped(HEARTBEAT))
    raw[2] = 0x02
    assert split(bytes(raw)) == []


def test_a_field_named_id_does_not_hide_the_message_id() -> None:
    text = mavlink.MAVLink_statustext_message(6, b"x", mavlink.MAVLINK_MSG_ID_COMMAND_LONG, 0)
    (received,) = split(wrapped(text))
    assert received.message_id == mavlink.MAVLINK_MSG_ID_STATUSTEXT


def test_messages_unknown_to_the_dialect_are_dropped() -> None:
    unknown = Packed(54321, b"\x01\x02", 99)
    raw = wrap(unknown, sequence=0, system=1, component=1)
    assert [item.message_id for item in split(raw + wrapped(HEARTBEAT))] == [0]


def test_a_flood_of_packet_starts_costs_a_bounded_number_of_attempts() -> None:
    assert split(b"\xfd" * 2048 + wrapped(HEARTBEAT)) == []
    assert MAX_BAD_PACKETS < 100


@given(st.binary(max_size=400))
def test_any_bytes_are_split_without_raising(datagram: bytes) -> None:
    assert sum(len(item.raw) for item in split(datagram)) <= len(datagram)
    cut = wrapped(HEARTBEAT)[:-2] + datagram
    assert sum(len(item.raw) for item in split(cut)) <= len(cut)


@given(st.sampled_from(sorted(mavlink.mavlink_map)), st.binary(min_size=1, max_size=255))
def test_any_payload_of_any_message_is_decoded_without_raising(
    message_id: int, payload: bytes
) -> None:
    crc_extra = mavlink.mavlink_map[message_id].crc_extra
    packed = Packed(message_id, payload, crc_extra)
    raw = wrap(packed, sequence=0, system=1, component=1)
    assert [item.message_id for item in split(raw)] == [message_id]
