"""Acknowledgements as a running PX4 gave them."""

import math
from typing import Any

import pytest

from sitl.mavlink.servers.command_server import CommandServer, is_addressed, parse
from sitl.mavlink.wire.dialect import AUTOPILOT, CAMERA, mavlink
from tests.unit.sitl.mavlink.fakes import FakeOutlet, FakeVehicle, make_request

NAN = math.nan
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
ATTITUDE = mavlink.MAVLINK_MSG_ID_ATTITUDE


class Bench:
    """A command server and its client."""

    def __init__(self) -> None:
        self.vehicle = FakeVehicle()
        self.server = CommandServer(self.vehicle, system=1)
        self.outlet = FakeOutlet()
        self.request = make_request(self.outlet, system=42, component=7)

    def long(self, command: int, *params: float, target: tuple[int, int] = (1, 1)) -> list[Any]:
        values = [*params, *[0.0] * (7 - len(params))]
        message = mavlink.MAVLink_command_long_message(*target, command, 0, *values)
        self.server.handle(message, self.request)
        return self.outlet.take()

    def int(self, command: int, *params: float, frame: int = 0, x: int = 0, y: int = 0) -> Any:
        values = [*params, *[0.0] * (5 - len(params))]
        message = mavlink.MAVLink_command_int_message(
            1, 1, frame, command, 0, 0, *values[:4], x, y, values[4]
        )
        self.server.handle(message, self.request)
        return self.outlet.take()


def summary(messages: list[Any]) -> list[Any]:
    """Names of messages, results of acknowledgements."""
    return [m.result if m.get_type() == "COMMAND_ACK" else m.get_type() for m in messages]


@pytest.mark.parametrize(
    ("message_id", "answer"),
    [
        (148, ["AUTOPILOT_VERSION", ACCEPTED]),
        (242, ["HOME_POSITION", ACCEPTED]),
        (30, ["ATTITUDE", ACCEPTED]),
        (9999, [DENIED]),
        (47, [DENIED]),
        (259, [DENIED]),
        (NAN, [DENIED]),
        (1e12, [DENIED]),
        (-1, [DENIED]),
    ],
)
def test_request_message(message_id: float, answer: list[Any]) -> None:
    assert summary(Bench().long(512, message_id)) == answer
    if math.isfinite(message_id):
        assert summary(Bench().int(512, message_id)) == answer


def test_protocol_version_is_sent_before_its_acknowledgement() -> None:
    bench = Bench()
    assert summary(bench.long(512, 300)) == [ACCEPTED]
    assert [packed.message_id for packed in bench.outlet.packed] == [300]
    assert summary(bench.long(519)) == [ACCEPTED]
    assert summary(bench.long(520)) == ["AUTOPILOT_VERSION", ACCEPTED]


def test_available_modes_all_or_one() -> None:
    bench = Bench()
    everything = summary(bench.long(512, 435, 0))
    assert everything[-1] == ACCEPTED
    assert len(everything) > 10
    assert summary(bench.long(512, 435, 3)) == ["AVAILABLE_MODES", ACCEPTED]
    assert summary(bench.long(512, 435, 99)) == [DENIED]


def test_an_unavailable_message_is_denied() -> None:
    bench = Bench()
    bench.vehicle.autopilot.change(home_valid=False)
    assert summary(bench.long(512, 242)) == [DENIED]


@pytest.mark.parametrize(
    ("message_id", "interval_us", "result"),
    [
        (ATTITUDE, 50_000, ACCEPTED),
        (ATTITUDE, -1, ACCEPTED),
        (ATTITUDE, 0, ACCEPTED),
        (ATTITUDE, 1e30, FAILED),
        (ATTITUDE, NAN, FAILED),
        (9999, 50_000, FAILED),
        (NAN, 50_000, FAILED),
        (0, 50_000, FAILED),
    ],
)
def test_set_message_interval(message_id: float, interval_us: float, result: int) -> None:
    assert summary(Bench().long(511, message_id, interval_us)) == [result]


def test_get_message_interval_says_what_was_set() -> None:
    bench = Bench()
    bench.long(511, ATTITUDE, 50_000)
    message, acknowledgement = bench.long(510, ATTITUDE)
    assert (message.message_id, message.interval_us) == (ATTITUDE, 50_000)
    assert acknowledgement.result == ACCEPTED
    assert bench.long(510, 115)[0].interval_us == -1
    assert bench.long(510, 9999)[0].interval_us == 0
    assert summary(bench.long(510, 1e9)) == [DENIED]


def test_do_set_mode_is_acknowledged_twice_and_set_mode_once() -> None:
    bench = Bench()
    bench.vehicle.autopilot.result = 1
    assert summary(bench.long(176, 1, 6, 0)) == [ACCEPTED, 1]
    message = mavlink.MAVLink_set_mode_message(1, 1, 4 << 16 | 3 << 24)
    bench.server.set_mode(message, bench.request)
    assert [(a.command, a.result) for a in bench.outlet.take()] == [(176, 1)]
    first, second = (command.params[:3] for command in bench.vehicle.autopilot.commands)
    assert first == (1.0, 6.0, 0.0)
    assert second == (1.0, 4.0, 3.0)


def test_an_acknowledgement_goes_to_whoever_asked() -> None:
    (answer,) = Bench().long(400, 1)
    assert (answer.command, answer.target_system, answer.target_component) == (400, 42, 7)
    assert (answer.progress, answer.result_param2) == (0, 0)


def test_silence_of_the_autopilot_is_silence_on_the_wire() -> None:
    bench = Bench()
    bench.vehicle.autopilot.result = None
    assert bench.long(400, 3) == []


@pytest.mark.parametrize("value", [2147483647.0, 2147483648.0])
def test_an_integers_not_given_in_a_float_is_denied(value: float) -> None:
    bench = Bench()
    assert summary(bench.long(22, NAN, NAN, NAN, NAN, value, NAN, NAN)) == [DENIED]
    assert bench.vehicle.autopilot.commands == []


@pytest.mark.parametrize("value", [math.inf, -math.inf])
def test_infinity_is_denied(value: float) -> None:
    bench = Bench()
    assert summary(bench.long(22, NAN, NAN, NAN, NAN, NAN, NAN, value)) == [DENIED]
    assert bench.vehicle.autopilot.commands == []


def test_command_int_gives_degrees_in_global_frames_and_metres_in_local_ones() -> None:
    bench = Bench()
    bench.int(192, -1, 1, NAN, NAN, 500.0, frame=5, x=473977428, y=85455967)
    bench.int(192, -1, 1, NAN, NAN, -5.0, frame=1, x=15000, y=-2500)
    bench.int(192, -1, 1, NAN, NAN, -5.0, frame=5, x=2**31 - 1, y=2**31 - 1)
    places = [command.params[4:] for command in bench.vehicle.autopilot.commands]
    assert places[0] == pytest.approx((47.3977428, 8.5455967, 500.0))
    assert places[1] == (1.5, -0.25, -5.0)
    assert all(math.isnan(value) for value in places[2][:2])


@pytest.mark.parametrize(
    ("command", "target", "answered"),
    [
        (400, (1, 1), True),
        (400, (1, 0), True),
        (400, (0, 0), False),
        (400, (0, 1), False),
        (400, (2, 1), False),
        (400, (1, 99), False),
        (520, (0, 0), True),
        (519, (0, 1), True),
        (520, (1, 99), True),
        (520, (2, 1), False),
    ],
)
def test_who_is_answered(command: int, target: tuple[int, int], answered: bool) -> None:  # noqa: FBT001
    message = mavlink.MAVLink_command_long_message(*target, command, 0, *[0.0] * 7)
    assert is_addressed(message, 1, AUTOPILOT) is answered


def test_the_camera_answers_only_to_its_own_number() -> None:
    def to(component: int, command: int = 512) -> Any:
        return mavlink.MAVLink_command_long_message(1, component, command, 0, *[0.0] * 7)

    assert is_addressed(to(CAMERA), 1, CAMERA)
    assert not is_addressed(to(0), 1, CAMERA)
    assert not is_addressed(to(1, 520), 1, CAMERA)


def test_a_command_long_is_in_the_global_frame() -> None:
    message = mavlink.MAVLink_command_long_message(1, 1, 22, 3, *[NAN] * 7)
    command = parse(message)
    assert command is not None
    assert command.frame == 0
    assert all(math.isnan(value) for value in command.params)
