"""Poses are what their vehicle told, and nothing else becomes one."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sitl.external.poses import PoseReader
from sitl.frames import HOME, geodetic_from_ned
from sitl.records.motion import VehicleState

LEVEL = (1.0, 0.0, 0.0, 0.0)
metres = st.floats(-200.0, 200.0)


def told(
    place_ned: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    time_us: int = 4000,
    quaternion: tuple[float, ...] = LEVEL,
) -> mavlink.MAVLink_hil_state_quaternion_message:
    latitude, longitude, altitude = geodetic_from_ned(place_ned, HOME)
    return mavlink.MAVLink_hil_state_quaternion_message(
        time_us,
        list(quaternion),
        *(0.1, 0.2, 0.3),
        *(round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1e3)),
        *(100, -200, 50, 0, 0, 0, 0, -1000),
    )


def read(reader: PoseReader, *messages: object) -> VehicleState | None:
    last = None
    for message in messages:
        last = reader.read(message)
    return last


@given(metres, metres, metres)
def test_a_place_is_where_it_was_told_to_the_centimetre(
    north: float, east: float, down: float
) -> None:
    pose = read(PoseReader(None), told(), told((north, east, down)))
    assert pose is not None
    assert pose.position_ned == pytest.approx((north, east, down), abs=0.02)
    assert pose.velocity_ned == pytest.approx((1.0, -2.0, 0.5))
    assert pose.specific_force_frd == pytest.approx((0.0, 0.0, -9.80665))


def test_without_a_time_of_its_own_the_newest_attitude_dates_it() -> None:
    reader = PoseReader(None)
    assert read(reader, told(time_us=0)) is None
    pose = read(reader, mavlink.MAVLink_attitude_message(1234, 0, 0, 0, 0, 0, 0), told(time_us=0))
    assert pose is not None
    assert pose.time_us == 1_234_000


@pytest.mark.parametrize("quaternion", [(0.0,) * 4, (math.nan,) * 4, (1.0, 1.0, 0.0, 0.0)])
def test_what_is_no_attitude_is_no_pose(quaternion: tuple[float, ...]) -> None:
    assert read(PoseReader(HOME), told(quaternion=quaternion)) is None
