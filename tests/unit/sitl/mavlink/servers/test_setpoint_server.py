"""SET_POSITION_TARGET_LOCAL_NED: the cases that a running PX4 was seen to take and refuse."""

import math
from typing import Any

import pytest

from sitl.mavlink.servers.setpoints.setpoint_server import SetpointServer, interpret
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.texts import StatusText
from sitl.records.vehicle import OffboardSetpoint
from tests.unit.sitl.mavlink.fakes import FakeVehicle

LOCAL_NED, BODY_NED = 1, 8
VELOCITY_AND_YAW_RATE = 0x5C7
EVERYTHING_IGNORED = 0x0DFF
NAN = math.nan


def make(frame: int = BODY_NED, mask: int = VELOCITY_AND_YAW_RATE, **fields: float) -> Any:
    names = ("x", "y", "z", "vx", "vy", "vz", "afx", "afy", "afz", "yaw", "yaw_rate")
    values = [fields.get(name, 0.0) for name in names]
    return mavlink.MAVLink_set_position_target_local_ned_message(1234, 1, 1, frame, mask, *values)


def taken(message: Any, yaw_rad: float = 0.0) -> OffboardSetpoint:
    setpoint = interpret(message, time_us=5_000_000, yaw_rad=yaw_rad)
    assert isinstance(setpoint, OffboardSetpoint)
    return setpoint


@pytest.mark.parametrize("frame", [0, 3, 6, 7, 9, 12, 20, 21])
def test_foreign_frames_are_refused_with_a_text(frame: int) -> None:
    text = interpret(make(frame), time_us=0, yaw_rad=0.0)
    expected = f"SET_POSITION_TARGET_LOCAL_NED coordinate frame {frame} unsupported"
    assert text == StatusText(severity=2, text=expected)


@pytest.mark.parametrize("ignored", [0x08, 0x10, 0x20])
def test_one_ignored_body_velocity_drops_them_all(ignored: int) -> None:
    text = interpret(make(mask=VELOCITY_AND_YAW_RATE | ignored), time_us=0, yaw_rad=0.0)
    assert text == StatusText(severity=2, text="SET_POSITION_TARGET_LOCAL_NED invalid")


@pytest.mark.parametrize("frame", [LOCAL_NED, BODY_NED])
def test_nothing_asked_is_refused(frame: int) -> None:
    text = interpret(make(frame, EVERYTHING_IGNORED), time_us=0, yaw_rad=0.0)
    assert text == StatusText(severity=2, text="SET_POSITION_TARGET_LOCAL_NED invalid")


def test_force_is_refused() -> None:
    text = interpret(make(LOCAL_NED, 0x0C3F | 1 << 9), time_us=0, yaw_rad=0.0)
    assert text == StatusText(severity=2, text="SET_POSITION_TARGET_LOCAL_NED force not supported")


def test_one_ignored_local_velocity_leaves_the_others() -> None:
    setpoint = taken(make(LOCAL_NED, VELOCITY_AND_YAW_RATE | 0x08, vx=9.0, vy=2.0, vz=-1.0))
    assert math.isnan(setpoint.velocity_ned[0])
    assert setpoint.velocity_ned[1:] == (2.0, -1.0)


@pytest.mark.parametrize(
    ("yaw_deg", "north", "east"), [(0, 1.0, 2.0), (90, -2.0, 1.0), (180, -1.0, -2.0)]
)
def test_body_velocity_is_turned_by_the_heading_alone(
    yaw_deg: float, north: float, east: float
) -> None:
    setpoint = taken(make(vx=1.0, vy=2.0, vz=0.5, yaw_rate=0.3), math.radians(yaw_deg))
    assert setpoint.velocity_ned == pytest.approx((north, east, 0.5))
    assert all(math.isnan(value) for value in setpoint.position_ned + setpoint.acceleration_ned)
    assert math.isnan(setpoint.yaw_rad)
    assert setpoint.yaw_rate_rad_s == 0.3
    assert setpoint.time_us == 5_000_000


def test_body_position_never_counts() -> None:
    setpoint = taken(make(BODY_NED, 0x0DC0, x=5.0, y=5.0, z=-5.0, vx=1.0))
    assert all(math.isnan(value) for value in setpoint.position_ned)
    assert setpoint.velocity_ned == (1.0, 0.0, 0.0)


def test_velocity_with_a_height() -> None:
    setpoint = taken(make(LOCAL_NED, 0x0DE3, z=-5.0, vx=1.0, vy=2.0))
    assert setpoint.position_ned[2] == -5.0
    assert math.isnan(setpoint.position_ned[0])
    assert setpoint.velocity_ned[:2] == (1.0, 2.0)
    assert math.isnan(setpoint.velocity_ned[2])


def test_yaw_is_absolute_in_either_frame() -> None:
    for frame in (LOCAL_NED, BODY_NED):
        setpoint = taken(make(frame, 0x09C7, vx=1.0, yaw=0.7), yaw_rad=2.0)
        assert setpoint.yaw_rad == 0.7
        assert math.isnan(setpoint.yaw_rate_rad_s)


@pytest.mark.parametrize("value", [NAN, math.inf, -math.inf, 1e30])
def test_an_absurd_number_counts_as_missing(value: float) -> None:
    setpoint = taken(make(LOCAL_NED, vx=value, vy=1.0, vz=0.0, yaw_rate=value))
    assert math.isnan(setpoint.velocity_ned[0])
    assert setpoint.velocity_ned[1:] == (1.0, 0.0)
    assert math.isnan(setpoint.yaw_rate_rad_s)
    refused = interpret(make(vx=value, vy=value, vz=value), time_us=0, yaw_rad=0.0)
    assert isinstance(refused, StatusText)


def test_a_body_setpoint_with_nan_forward_is_passed_on_without_horizontal_velocity() -> None:
    setpoint = taken(make(vx=NAN, vy=1.0, vz=0.5))
    assert math.isnan(setpoint.velocity_ned[0])
    assert math.isnan(setpoint.velocity_ned[1])
    assert setpoint.velocity_ned[2] == 0.5


def test_the_server_remembers_the_image_that_is_answered_even_if_it_refuses() -> None:
    vehicle = FakeVehicle()
    vehicle.time_us = 1_234_000
    server = SetpointServer(vehicle)
    assert server.take_answer() == -1
    assert server.handle(make(vx=1.0)) is None
    assert len(vehicle.autopilot.setpoints) == 1
    assert server.take_answer() == 1_234_000
    assert server.take_answer() == -1
    assert server.handle(make(12)) is not None
    assert len(vehicle.autopilot.setpoints) == 1
    assert server.take_answer() == 1_234_000


def test_no_setpoint_answers_an_image_that_is_yet_to_come() -> None:
    vehicle = FakeVehicle()
    vehicle.time_us = 1_232_000
    server = SetpointServer(vehicle)
    assert server.handle(make(vx=1.0)) is None
    assert server.take_answer() == -1
    assert len(vehicle.autopilot.setpoints) == 1
