"""MAVSDK, written by others, finds the vehicle, flies a square with it in offboard, and lands."""

from collections.abc import Iterator
from functools import partial
from operator import eq
from pathlib import Path
from typing import Any

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.offboard import Offboard, VelocityBodyYawspeed
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from tests.flight.mavsdk_vehicle import Latest, found_vehicle

pytestmark = pytest.mark.flight
LEG_M = 3.0
ACROSS_M = 1.0  # how far a leg may stray sideways


@pytest.fixture
def system(tmp_path: Path) -> Iterator[System]:
    with found_vehicle(tmp_path) as found:
        yield found


def test_flies_a_square_in_offboard_and_lands(system: System) -> None:
    telemetry, action, offboard = Telemetry(system), Action(system), Offboard(system)
    in_air = Latest(telemetry.subscribe_landed_state)
    motion = Latest(telemetry.subscribe_position_velocity_ned)
    mode = Latest(telemetry.subscribe_flight_mode)
    healthy = Latest(telemetry.subscribe_health_all_ok)
    armed = Latest(telemetry.subscribe_armed)

    healthy.until(bool, "healthy", timeout_s=20.0)
    action.arm()
    action.takeoff()
    in_air.until(lambda state: state == LandedState.IN_AIR, "in the air", timeout_s=10.0)
    for expected in (FlightMode.TAKEOFF, FlightMode.HOLD):
        mode.until(partial(eq, expected), str(expected), timeout_s=10.0)

    offboard.set_velocity_body(VelocityBodyYawspeed())
    offboard.start()
    mode.until(lambda value: value == FlightMode.OFFBOARD, "offboard", timeout_s=5.0)
    start = _now(motion)
    assert -start.down_m > 1.5
    for forward, right in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)):
        _fly_leg(offboard, motion, forward, right)
    end = _now(motion)
    assert abs(end.north_m - start.north_m) < ACROSS_M
    assert abs(end.east_m - start.east_m) < ACROSS_M

    action.land()
    in_air.until(lambda state: state == LandedState.ON_GROUND, "landed", timeout_s=15.0)
    armed.until(lambda value: not value, "disarmed", timeout_s=5.0)


def _fly_leg(offboard: Offboard, motion: Latest, forward: float, right: float) -> None:
    """Fly one side; the vehicle faces north, so forward is north and right is east."""
    before = _now(motion)
    offboard.set_velocity_body(VelocityBodyYawspeed(forward, right, 0.0, 0.0))

    def along_m(sample: Any) -> float:
        north_m = sample.position.north_m - before.north_m
        east_m = sample.position.east_m - before.east_m
        return float(forward * north_m + right * east_m)

    motion.until(lambda sample: along_m(sample) > LEG_M, "the end of a leg", timeout_s=10.0)
    offboard.set_velocity_body(VelocityBodyYawspeed())
    motion.until(_at_rest, "rest after a leg", timeout_s=10.0)
    after = _now(motion)
    across_m = right * (after.north_m - before.north_m) + forward * (after.east_m - before.east_m)
    assert abs(across_m) < ACROSS_M


def _at_rest(sample: Any) -> bool:
    velocity = sample.velocity
    return bool(abs(velocity.north_m_s) < 0.1 and abs(velocity.east_m_s) < 0.1)


def _now(motion: Latest) -> Any:
    return motion.next().position
