"""No command takes a vehicle past our own limits, and whoever is outside is held, then landed."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from flightstack.companion.guards.limits import SLACK_M, FlightLimits, place
from flightstack.companion.mission.records import MissionPhase, Outcome
from flightstack.errors import UsageError
from flightstack.mavlink.offboard import Velocities
from flightstack.mavlink.telemetry import Telemetry
from tests.unit.flightstack.companion.made_flight import MadeFlight, forward_m_s

LIMITS = FlightLimits(
    min_height_m=1.0,
    max_height_m=6.0,
    max_distance_m=20.0,
    max_speed_m_s=8.0,
    max_climb_m_s=2.0,
    max_descent_m_s=1.5,
)
IMAGE_S, TICK_S, ANSWERS_S = 0.05, 0.005, 0.15  # of a velocity loop, as PX4's
ANY = st.floats(-1e6, 1e6)
COMMANDS = st.lists(st.tuples(ANY, ANY, ANY, ANY), min_size=1, max_size=4)
START = Telemetry(position_ned=(0.0, 0.0, -3.0), velocity_ned=(0.0, 0.0, 0.0))


class Follower:
    """A vehicle that follows velocities with a lag, and turns as it is told."""

    def __init__(self) -> None:
        self.position = np.array([0.0, 0.0, -3.0])
        self.velocity = np.zeros(3)
        self.yaw = 0.0

    @property
    def telemetry(self) -> Telemetry:
        north, east, down = map(float, self.position)
        return replace(START, position_ned=(north, east, down))

    def follow(self, velocities: Velocities) -> None:
        forward, right, down, yaw_rate = velocities
        for _ in range(round(IMAGE_S / TICK_S)):
            self.yaw += TICK_S * max(-1.0, min(1.0, yaw_rate))
            cos, sin = math.cos(self.yaw), math.sin(self.yaw)
            wanted = np.array([cos * forward - sin * right, sin * forward + cos * right, down])
            self.velocity += (wanted - self.velocity) * TICK_S / ANSWERS_S
            self.position += self.velocity * TICK_S


@given(commands=COMMANDS)
def test_whatever_is_asked_the_vehicle_stays_inside(commands: list[Velocities]) -> None:
    vehicle = Follower()
    for image in range(400):
        asked = commands[image * len(commands) // 400]
        vehicle.follow(LIMITS.clip(asked, vehicle.telemetry))
        height_m, distance_m = place(vehicle.telemetry)
        assert LIMITS.min_height_m - SLACK_M < height_m < LIMITS.max_height_m + SLACK_M
        assert distance_m < LIMITS.max_distance_m + SLACK_M


@given(command=st.tuples(ANY, ANY, ANY, ANY), place_ned=st.tuples(ANY, ANY, ANY))
def test_whatever_is_asked_anywhere_is_no_faster_than_allowed(
    command: Velocities, place_ned: tuple[float, float, float]
) -> None:
    vehicle = replace(START, position_ned=place_ned)
    forward, right, down, yaw_rate = LIMITS.clip(command, vehicle)
    assert math.hypot(forward, right) <= LIMITS.max_speed_m_s * (1 + 1e-9)
    assert -LIMITS.max_climb_m_s <= down <= LIMITS.max_descent_m_s
    assert yaw_rate == command[3]


@given(forward=st.floats(-4, 4), right=st.floats(-4, 4), down=st.floats(-1.4, 1.4))
def test_far_from_any_limit_nothing_is_changed(forward: float, right: float, down: float) -> None:
    command = (forward, right, down, 0.5)
    assert LIMITS.clip(command, START) == command


@pytest.mark.parametrize(
    ("position_ned", "velocity_ned", "option"),
    [
        ((0.0, 0.0, -0.4), (0.0, 0.0, 0.0), "--min-height"),
        ((0.0, 0.0, -6.6), (0.0, 0.0, 0.0), "--max-height"),
        ((12.0, 16.0, -3.0), (0.0, 0.0, 0.0), "--max-distance"),
        ((0.0, 0.0, -3.0), (9.0, 9.0, 0.0), "--max-speed"),
        ((0.0, 0.0, -3.0), (0.0, 0.0, -4.0), "--max-climb"),
        ((0.0, 0.0, -3.0), (0.0, 0.0, 3.0), "--max-descent"),
    ],
)
def test_each_limit_has_its_word(
    position_ned: tuple[float, float, float],
    velocity_ned: tuple[float, float, float],
    option: str,
) -> None:
    there = replace(START, position_ned=position_ned, velocity_ned=velocity_ned)
    assert option in str(LIMITS.breach(there))
    home = replace(there, home_ned=position_ned, velocity_ned=(0.0, 0.0, 0.0))
    assert "--min-height" in str(LIMITS.breach(home))  # on the ground, wherever that is


def test_inside_nothing_is_said() -> None:
    assert LIMITS.breach(START) is None
    assert LIMITS.breach(Telemetry()) is None


def test_a_band_without_height_is_refused() -> None:
    with pytest.raises(UsageError, match="--min-height 5 must lie below --max-height 5"):
        FlightLimits(min_height_m=5.0, max_height_m=5.0)


def test_a_vehicle_outside_is_held_then_landed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flight = MadeFlight(tmp_path, monkeypatch)
    flight.turn(50)
    flight.made.say(common.MAVLink_local_position_ned_message(50, 0, 0, -80, 0, 0, 0))
    assert forward_m_s(flight.turn(50)) == [0.0]
    assert "80.0 m high: --max-height" in flight.said.getvalue()
    for _ in range(41):
        flight.turn(50)
    assert flight.phase() is MissionPhase.LANDING
    assert flight.loop.status.outcome is Outcome.OUT_OF_LIMITS
