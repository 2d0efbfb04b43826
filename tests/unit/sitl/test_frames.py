"""The literal table here stands in the companion's tests too: one sign error cannot cancel."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.frames import (
    euler_from_quaternion,
    flip,
    from_bullet_quaternion,
    geodetic_from_ned,
    ned_from_geodetic,
    quaternion_from_euler,
    rotate,
    rotate_inverse,
    to_bullet_quaternion,
    wrap_pi,
    yaw_of,
)

ANGLES = st.floats(-1.4, 1.4)
HOME = (47.397742, 8.545594, 489.4)


@pytest.mark.parametrize(
    ("yaw_deg", "body", "ned"),
    [
        (0.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),  # nose north: forward is north
        (90.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),  # nose east: forward is east
        (90.0, (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),  # nose east: right is south
        (-90.0, (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)),  # nose west: forward is west
        (45.0, (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)),  # down is down
    ],
)
def test_body_to_ned_by_heading(
    yaw_deg: float, body: tuple[float, float, float], ned: tuple[float, float, float]
) -> None:
    q = quaternion_from_euler(0.0, 0.0, math.radians(yaw_deg))
    assert rotate(q, body) == pytest.approx(ned)


def test_nose_up_is_positive_pitch_and_right_down_is_positive_roll() -> None:
    assert rotate(quaternion_from_euler(0.0, 0.3, 0.0), (1.0, 0.0, 0.0))[2] < 0.0
    assert rotate(quaternion_from_euler(0.3, 0.0, 0.0), (0.0, 1.0, 0.0))[2] > 0.0


@given(ANGLES, ANGLES, st.floats(-3.1, 3.1))
def test_euler_angles_return(roll: float, pitch: float, yaw: float) -> None:
    q = quaternion_from_euler(roll, pitch, yaw)
    assert euler_from_quaternion(q) == pytest.approx((roll, pitch, yaw), abs=1e-9)
    assert yaw_of(q) == pytest.approx(yaw, abs=1e-9)


@given(ANGLES, ANGLES, ANGLES)
def test_rotation_and_its_inverse_cancel(roll: float, pitch: float, yaw: float) -> None:
    q = quaternion_from_euler(roll, pitch, yaw)
    assert rotate_inverse(q, rotate(q, (1.0, -2.0, 3.0))) == pytest.approx((1.0, -2.0, 3.0))


@given(ANGLES, ANGLES, ANGLES)
def test_pybullets_frames_rotate_alike(roll: float, pitch: float, yaw: float) -> None:
    q = quaternion_from_euler(roll, pitch, yaw)
    x, y, z, w = to_bullet_quaternion(q)
    vector = (0.3, -1.2, 2.0)
    assert flip(rotate((w, x, y, z), flip(vector))) == pytest.approx(rotate(q, vector))
    assert from_bullet_quaternion((x, y, z, w)) == pytest.approx(q)


def test_geodesy_returns_and_a_minute_of_latitude_is_a_sea_mile() -> None:
    point = geodetic_from_ned((123.0, -45.0, -6.0), HOME)
    assert ned_from_geodetic(point, HOME) == pytest.approx((123.0, -45.0, -6.0), abs=1e-6)
    north, east, _ = ned_from_geodetic((HOME[0] + 1 / 60, HOME[1], HOME[2]), HOME)
    assert north == pytest.approx(1852.0, rel=2e-3)
    assert east == pytest.approx(0.0)


@pytest.mark.parametrize("turns", [-2, 0, 3])
def test_wrapping_keeps_the_direction(turns: int) -> None:
    assert wrap_pi(1.0 + 2 * math.pi * turns) == pytest.approx(1.0)
    assert wrap_pi(-math.pi) == math.pi
