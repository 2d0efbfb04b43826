import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.autopilot.control.trajectory import Agility, Trajectory
from sitl.clock import TICK_S

ZERO = (0.0, 0.0, 0.0)
AGILITY = Agility(acceleration_m_s2=3.0, jerk_m_s3=4.0)


@settings(deadline=None, max_examples=25)
@given(distance=st.floats(0.3, 30.0), cruise=st.floats(2.0, 8.0))
def test_approach_arrives_without_overshoot(distance: float, cruise: float) -> None:
    trajectory = Trajectory(ZERO, ZERO, ZERO)
    furthest = fastest = 0.0
    for _ in range(int((10.0 + 2.0 * distance / cruise) / TICK_S)):
        trajectory.approach_xy(0.6 * distance, 0.8 * distance, cruise, AGILITY)
        x, y, _ = trajectory.position
        furthest = max(furthest, math.hypot(x, y))
        fastest = max(fastest, math.hypot(*trajectory.velocity))
    assert furthest < distance + 0.05
    assert math.dist(trajectory.position, (0.6 * distance, 0.8 * distance, 0.0)) < 0.02
    assert fastest < cruise + 0.01


@settings(deadline=None, max_examples=25)
@given(speed=st.floats(-8.0, 8.0))
def test_stop_ends_at_rest_within_the_limits(speed: float) -> None:
    trajectory = Trajectory(ZERO, (speed, 0.0, 0.0), ZERO)
    before = 0.0
    for _ in range(int(6.0 / TICK_S)):
        trajectory.stop_xy(AGILITY)
        acceleration = trajectory.north.acceleration
        assert abs(acceleration) <= 3.0 + 1e-9
        assert abs(acceleration - before) <= 4.0 * TICK_S + 0.1
        before = acceleration
    assert trajectory.velocity == (0.0, 0.0, 0.0)
    assert trajectory.north.position * speed >= 0.0


def test_speed_is_reached_and_kept() -> None:
    trajectory = Trajectory(ZERO, ZERO, ZERO)
    for _ in range(int(4.0 / TICK_S)):
        trajectory.down.lead(0.7, AGILITY)
    assert trajectory.velocity[2] == 0.7
    assert trajectory.acceleration[2] == 0.0


def test_height_is_approached_from_either_side() -> None:
    for start in (-10.0, 5.0):
        trajectory = Trajectory((0.0, 0.0, start), ZERO, ZERO)
        for _ in range(int(10.0 / TICK_S)):
            trajectory.approach_z(-3.0, 3.0, AGILITY)
        assert trajectory.position[2] == pytest.approx(-3.0, abs=0.01)


def test_waits_for_a_vehicle_that_is_far_behind() -> None:
    trajectory = Trajectory((5.0, 0.0, 0.0), ZERO, ZERO)
    assert trajectory.lags((2.9, 0.0, 0.0))
    assert not trajectory.lags((3.1, 0.0, 50.0))
