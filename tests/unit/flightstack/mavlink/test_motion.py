"""Poses by telemetry, at any stamp that it reaches."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from flightstack.mavlink.motion import MotionHistory

SPEED = (1.0, -0.5, 0.2)
TURN = 0.8  # rad/s


def told(history: MotionHistory, time_ms: int, *, attitude: bool = True) -> None:
    """Tell a motion that is uniform, position and heading."""
    t = time_ms / 1000.0
    if attitude:
        yaw = math.remainder(TURN * t, 2 * math.pi)
        history.note_attitude(mavlink.MAVLink_attitude_message(time_ms, 0.1, -0.1, yaw, 0, 0, TURN))
    place = [speed * t for speed in SPEED]
    history.note_position(mavlink.MAVLink_local_position_ned_message(time_ms, *place, *SPEED))


@given(st.integers(0, 4_300_000))
def test_between_and_a_moment_after_what_was_told_it_is_where_it_was(time_us: int) -> None:
    history = MotionHistory()
    for time_ms in range(0, 4001, 80):
        told(history, time_ms)
    pose = history.at(time_us)
    if time_us < 0 or pose is None:
        assert time_us > 4_300_000
        return
    expected = [speed * time_us / 1e6 for speed in SPEED]
    assert pose.position_ned == pytest.approx(expected, abs=1e-4)
    assert math.remainder(pose.yaw_rad - TURN * time_us / 1e6, 2 * math.pi) == pytest.approx(
        0.0, abs=1e-4
    )


def test_where_telemetry_does_not_reach_nothing_is_known() -> None:
    history = MotionHistory()
    assert history.latest is None
    assert history.displacement_m_s(0.4) is None
    told(history, 1000)
    assert history.at(900_000) is None
    assert history.at(1_400_000) is None
    assert history.at(1_200_000) is not None


def test_what_repeats_or_comes_late_changes_nothing_and_a_restart_forgets() -> None:
    history = MotionHistory()
    for time_ms in (5000, 5050, 5050, 5020):
        told(history, time_ms)
    latest = history.latest
    assert latest is not None
    assert latest.time_us == 5_050_000
    told(history, 200)
    latest = history.latest
    assert latest is not None
    assert latest.time_us == 200_000
    assert history.at(5_000_000) is None


def test_numbers_that_are_none_are_not_taken() -> None:
    history = MotionHistory()
    told(history, 1000)
    nan = math.nan
    history.note_attitude(mavlink.MAVLink_attitude_message(1050, nan, 0, 0, 0, 0, 0))
    history.note_position(mavlink.MAVLink_local_position_ned_message(1050, nan, 0, 0, 0, 0, 0))
    latest = history.latest
    assert latest is not None
    assert latest.time_us == 1_000_000


def test_displacement_is_of_the_position_told_not_of_the_velocity() -> None:
    history = MotionHistory()
    for step in range(20):
        place = (0.1 * step, 0.0, -3.0)
        message = mavlink.MAVLink_local_position_ned_message(step * 100, *place, 9.0, 9.0, 9.0)
        history.note_position(message)
    assert history.displacement_m_s(0.4) == pytest.approx((1.0, 0.0, 0.0), abs=1e-5)
