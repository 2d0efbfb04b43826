"""The servers that answer in one message: time, events."""

import pytest

from sitl.mavlink.servers import event_server, time_server
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.newer_messages import RequestEvent
from tests.unit.sitl.mavlink.fakes import FakeOutlet, make_request


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


def test_events_that_there_are_not_are_said_to_be_unavailable_once(outlet: FakeOutlet) -> None:
    message = RequestEvent(3, 65535, 1, 1)
    event_server.answer_request(message, make_request(outlet, system=42, component=7))
    (answer,) = outlet.messages
    assert answer.get_type() == "RESPONSE_EVENT_ERROR"
    assert (answer.target_system, answer.target_component) == (42, 7)
    assert (answer.sequence, answer.sequence_oldest_available, answer.reason) == (3, 0, 0)
