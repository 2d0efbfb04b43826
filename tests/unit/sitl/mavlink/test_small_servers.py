"""The servers that answer in one message: time, files, logs."""

import struct
from typing import Any

import pytest

from sitl.mavlink import file_server, time_server
from sitl.mavlink.dialect import mavlink
from tests.unit.sitl.mavlink.fakes import FakeOutlet, make_request

NAK, ACK = 129, 128


@pytest.fixture
def outlet() -> FakeOutlet:
    return FakeOutlet()


def test_timesync_requests_get_boot_time_in_nanoseconds(outlet: FakeOutlet) -> None:
    message = mavlink.MAVLink_timesync_message(0, 987654321)
    time_server.answer_timesync(message, make_request(outlet), 4_000)
    (answer,) = outlet.messages
    assert (answer.tc1, answer.ts1) == (4_000_000, 987654321)


def test_timesync_answers_are_not_answered(outlet: FakeOutlet) -> None:
    message = mavlink.MAVLink_timesync_message(5, 987654321)
    time_server.answer_timesync(message, make_request(outlet), 4_000)
    assert outlet.messages == []


def test_a_ping_to_everybody_is_answered_to_its_sender(outlet: FakeOutlet) -> None:
    request = make_request(outlet, system=42, component=7)
    time_server.answer_ping(mavlink.MAVLink_ping_message(123, 9, 0, 0), request)
    (answer,) = outlet.messages
    assert (answer.time_usec, answer.seq) == (123, 9)
    assert (answer.target_system, answer.target_component) == (42, 7)


def test_a_ping_to_the_vehicle_is_an_answer_and_gets_none(outlet: FakeOutlet) -> None:
    time_server.answer_ping(mavlink.MAVLink_ping_message(123, 9, 1, 1), make_request(outlet))
    assert outlet.messages == []


def transfer(opcode: int, outlet: FakeOutlet) -> list[Any]:
    payload = struct.pack("<HBBBBBBI", 65535, 3, opcode, 18, 0, 0, 0, 0) + b"@PARAM/param.pck"
    message = mavlink.MAVLink_file_transfer_protocol_message(
        0, 1, 1, list(payload.ljust(251, b"\0"))
    )
    file_server.answer_file_transfer(message, make_request(outlet, system=42, component=7))
    return outlet.messages


@pytest.mark.parametrize(
    ("opcode", "answer", "error"),
    [(1, ACK, None), (2, ACK, None), (4, NAK, 10), (3, NAK, 10), (15, NAK, 10), (6, NAK, 7)],
)
def test_there_are_no_files(
    outlet: FakeOutlet, opcode: int, answer: int, error: int | None
) -> None:
    (message,) = transfer(opcode, outlet)
    payload = bytes(message.payload)
    sequence, session, replied, size, request = struct.unpack("<HBBBB", payload[:6])
    assert (sequence, session, replied, request) == (0, 3, answer, opcode)
    assert size == (0 if error is None else 1)
    assert payload[12] == (error or 0)
    assert (message.target_system, message.target_component) == (42, 7)


@pytest.mark.parametrize("opcode", [ACK, NAK])
def test_answers_of_others_are_not_answered(outlet: FakeOutlet, opcode: int) -> None:
    assert transfer(opcode, outlet) == []


def test_there_are_no_logs(outlet: FakeOutlet) -> None:
    file_server.answer_log_list(None, make_request(outlet))
    assert [(m.get_type(), m.num_logs) for m in outlet.messages] == [("LOG_ENTRY", 0)]
