"""Attitude and global setpoints, and sticks: what is taken, and what is refused."""

import math
from typing import Any

import pytest

from sitl.frames import ned_from_geodetic
from sitl.mavlink.servers.setpoints.attitude_setpoint import interpret_attitude
from sitl.mavlink.servers.setpoints.manual_control import interpret_sticks
from sitl.mavlink.servers.setpoints.setpoint_server import SetpointServer, interpret_global
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.texts import StatusText
from sitl.records.vehicle import AttitudeTarget, OffboardSetpoint, Sticks
from tests.unit.sitl.mavlink.fakes import HOME, FakeVehicle

NAN = math.nan
LEVEL = (1.0, 0.0, 0.0, 0.0)
ATTITUDE_ONLY, RATES_ONLY = 0b0000_0111, 0b1000_0000
POSITION_ONLY = 0b1101_1111_1000
REFUSED = StatusText(severity=2, text="SET_ATTITUDE_TARGET invalid")


def attitude(
    mask: int = ATTITUDE_ONLY,
    q: Any = LEVEL,
    rates: tuple[float, float, float] = (0.1, 0.2, 0.3),
    thrust: float = 0.6,
) -> Any:
    message = mavlink.MAVLink_set_attitude_target_message(1500, 1, 1, mask, q, *rates, thrust)
    return interpret_attitude(message, time_us=7000)


def test_an_attitude_is_normalised_and_its_ignored_rates_do_not_count() -> None:
    target = attitude(q=(1.05, 0.0, 0.0, 0.0))
    assert target == AttitudeTarget(
        time_us=7000, q_ned_frd=LEVEL, rates_frd=(0.0, 0.0, 0.0), thrust=0.6
    )


def test_beside_an_attitude_only_the_yaw_rate_counts() -> None:
    assert attitude(mask=0).rates_frd == (0.0, 0.0, 0.3)


def test_rates_alone() -> None:
    target = attitude(mask=RATES_ONLY)
    assert (target.q_ned_frd, target.rates_frd) == (None, (0.1, 0.2, 0.3))


@pytest.mark.parametrize(
    "changes",
    [
        {"mask": ATTITUDE_ONLY | 64},
        {"mask": ATTITUDE_ONLY | RATES_ONLY},
        {"mask": RATES_ONLY | 1},
        {"mask": RATES_ONLY, "rates": (NAN, 0.0, 0.0)},
        {"mask": RATES_ONLY, "rates": (0.0, math.inf, 0.0)},
        {"mask": RATES_ONLY, "rates": (0.0, 0.0, 1e9)},
        {"thrust": NAN},
        {"thrust": -0.1},
        {"thrust": 1.1},
        {"q": (0.0, 0.0, 0.0, 0.0)},
        {"q": (NAN, 0.0, 0.0, 0.0)},
        {"q": (math.inf, 0.0, 0.0, 0.0)},
    ],
)
def test_what_can_not_be_flown_is_refused(changes: dict[str, Any]) -> None:
    assert attitude(**changes) == REFUSED


def place(frame: int, altitude_m: float, mask: int = POSITION_ONLY) -> Any:
    message = mavlink.MAVLink_set_position_target_global_int_message(
        1500, 1, 1, frame, mask, 473978000, 85457000, altitude_m, 0, 0, 0, 0, 0, 0, 0.5, 0.0
    )
    return interpret_global(message, time_us=7000, origin=HOME, home_ned=(0.0, 0.0, -1.0))


@pytest.mark.parametrize(
    ("frame", "altitude_m", "down"), [(5, HOME[2] + 6.0, -6.0), (6, 6.0, -7.0), (11, 6.0, -7.0)]
)
def test_a_place_on_earth_becomes_local(frame: int, altitude_m: float, down: float) -> None:
    setpoint = place(frame, altitude_m)
    assert isinstance(setpoint, OffboardSetpoint)
    north, east, _ = ned_from_geodetic((47.3978, 8.5457, 0.0), HOME)
    assert setpoint.position_ned == pytest.approx((north, east, down), abs=1e-4)
    assert setpoint.time_us == 7000
    assert all(math.isnan(number) for number in setpoint.velocity_ned)


@pytest.mark.parametrize("frame", [0, 1, 3, 8, 10, 255])
def test_other_frames_are_refused(frame: int) -> None:
    text = f"SET_POSITION_TARGET_GLOBAL_INT coordinate frame {frame} unsupported"
    assert place(frame, 6.0) == StatusText(severity=2, text=text)


def test_a_global_setpoint_that_says_nothing_is_refused() -> None:
    refused = place(6, NAN, mask=0xDFF)
    assert refused == StatusText(severity=2, text="SET_POSITION_TARGET_GLOBAL_INT invalid")
    assert math.isnan(place(6, NAN).position_ned[2])


def sticks(x: int, y: int, z: int, r: int) -> Sticks | None:
    message = mavlink.MAVLink_manual_control_message(1, x, y, z, r, 0)
    return interpret_sticks(message, time_us=7000)


def test_sticks_go_from_minus_one_to_one() -> None:
    assert sticks(1000, -500, 500, 250) == Sticks(
        time_us=7000, forward=1.0, right=-0.5, up=0.0, turn=0.25
    )
    assert sticks(0, 0, 1000, 0).up == 1.0  # type: ignore[union-attr]
    assert sticks(0, 0, 0, 0).up == -1.0  # type: ignore[union-attr]


@pytest.mark.parametrize("axes", [(32767, 0, 500, 0), (0, 0, 1001, 0), (0, -1001, 0, 0)])
def test_missing_or_absurd_sticks_count_as_none(axes: tuple[int, int, int, int]) -> None:
    assert sticks(*axes) is None


def test_the_server_passes_them_on_and_counts_them_as_answers() -> None:
    vehicle = FakeVehicle()
    vehicle.time_us = 1_500_000
    server = SetpointServer(vehicle)
    message = mavlink.MAVLink_set_attitude_target_message(
        1500, 1, 1, ATTITUDE_ONLY, LEVEL, 0, 0, 0, 0.6
    )
    assert server.handle_attitude(message) is None
    assert len(vehicle.autopilot.targets) == 1
    assert server.take_answer() == 1_500_000
    server.handle_sticks(mavlink.MAVLink_manual_control_message(1, 0, 0, 500, 0, 0))
    server.handle_sticks(mavlink.MAVLink_manual_control_message(1, 32767, 0, 500, 0, 0))
    assert len(vehicle.autopilot.sticks) == 1
    assert server.take_answer() == -1
