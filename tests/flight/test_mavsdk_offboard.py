"""Scenarios that PX4 publishes for MAVSDK: offboard by position and attitude, sticks, failures."""

import math
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.failure import Failure, FailureError, FailureResult, FailureType, FailureUnit
from mavsdk.plugins.manual_control import ManualControl
from mavsdk.plugins.offboard import Attitude, AttitudeRate, Offboard, PositionNedYaw
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from tests.flight.mavsdk_vehicle import SPEED_FACTOR, Latest, found_vehicle

pytestmark = pytest.mark.flight
LEG_TIME_S, WITHIN_M = 10.0, 0.3  # PX4's own figures
HOVER_THRUST = 0.6
STICKS_SPEED_FACTOR = 2.0  # COM_RC_LOSS_T is then a quarter of a second of wall time
STICKS_HZ = 40.0


@pytest.fixture
def system(tmp_path: Path) -> Iterator[System]:
    with found_vehicle(tmp_path) as found:
        yield found


def test_offboard_by_position_and_attitude(system: System) -> None:
    telemetry, action, offboard = Telemetry(system), Action(system), Offboard(system)
    motion = Latest(telemetry.subscribe_position_velocity_ned)
    mode = Latest(telemetry.subscribe_flight_mode)
    state = Latest(telemetry.subscribe_landed_state)
    arm_when_healthy(telemetry, action)
    start = motion.next().position

    offboard.set_position_ned(PositionNedYaw(start.north_m, start.east_m, start.down_m - 3.0, 0.0))
    offboard.start()
    mode.until(lambda value: value == FlightMode.OFFBOARD, "offboard", timeout_s=5.0)
    for north, east, up in ((0.0, 0.0, 4.0), (5.0, 0.0, 4.0), (5.0, -5.0, 4.0), (0.0, 0.0, 4.0)):
        place = (start.north_m + north, start.east_m + east, start.down_m - up)
        fly_leg(offboard, motion, place)

    climb_by_attitude(offboard, motion)
    offboard.set_attitude_rate(AttitudeRate(0.0, 0.0, 30.0, HOVER_THRUST))
    heading = Latest(telemetry.subscribe_attitude_euler)
    before = heading.next().yaw_deg
    heading.until(lambda angle: abs(angle.yaw_deg - before) > 15.0, "turned", timeout_s=5.0)

    action.land()
    state.until(lambda value: value == LandedState.ON_GROUND, "landed", timeout_s=20.0)


def fly_leg(offboard: Offboard, motion: Latest, place: tuple[float, float, float]) -> None:
    offboard.set_position_ned(PositionNedYaw(*place, 0.0))

    def is_there(sample: Any) -> bool:
        at = sample.position
        return math.dist((at.north_m, at.east_m, at.down_m), place) < WITHIN_M

    motion.drain()
    motion.until(is_there, f"at {place}", timeout_s=LEG_TIME_S / SPEED_FACTOR)


def climb_by_attitude(offboard: Offboard, motion: Latest) -> None:
    start_m = -motion.next().position.down_m
    offboard.set_attitude(Attitude(0.0, 0.0, 0.0, HOVER_THRUST + 0.1))
    motion.until(lambda sample: -sample.position.down_m > start_m + 2.0, "climbed", timeout_s=5.0)


def test_position_control_by_sticks_and_refused_failure(tmp_path: Path) -> None:
    with found_vehicle(tmp_path, f"--speed-factor={STICKS_SPEED_FACTOR}") as system:
        refuse_failure(Failure(system))
        telemetry, action = Telemetry(system), Action(system)
        motion = Latest(telemetry.subscribe_position_velocity_ned)
        mode = Latest(telemetry.subscribe_flight_mode)
        armed = Latest(telemetry.subscribe_armed)
        sticks = ManualControl(system)
        with Sticks(sticks) as hands:
            time.sleep(0.2)
            arm_when_healthy(telemetry, action)
            sticks.start_position_control()
            mode.until(lambda value: value == FlightMode.POSCTL, "position", timeout_s=5.0)
            start = motion.next().position
            hands.hold(up=1.0)
            motion.until(lambda s: s.position.down_m < start.down_m - 2.0, "up", timeout_s=20.0)
            hands.hold(forward=0.5)
            motion.until(lambda s: s.position.north_m > start.north_m + 3.0, "on", timeout_s=20.0)
            hands.hold()
            motion.until(is_at_rest, "at rest", timeout_s=10.0)
            hands.hold(up=-1.0)
            armed.until(lambda value: not value, "landed and disarmed", timeout_s=30.0)


def refuse_failure(failure: Failure) -> None:
    with pytest.raises(FailureError) as refusal:
        failure.inject(FailureUnit.SENSOR_GPS, FailureType.OFF, 0)
    # MAVSDK knows of it by SYS_FAILURE_EN, or, before it has read that, by the vehicle's answer.
    refused = (FailureResult.DISABLED.name, FailureResult.DENIED.name)
    assert str(refusal.value).startswith(refused)


def arm_when_healthy(telemetry: Telemetry, action: Action) -> None:
    healthy = Latest(telemetry.subscribe_health_all_ok)
    healthy.until(bool, "healthy", timeout_s=20.0)
    action.arm()


def is_at_rest(sample: Any) -> bool:
    velocity = sample.velocity
    return math.hypot(velocity.north_m_s, velocity.east_m_s) < 0.2


class Sticks:
    """Hands that send the sticks' positions until they let go."""

    def __init__(self, control: ManualControl) -> None:
        self._control = control
        self._axes = (0.0, 0.0, 0.5, 0.0)
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._send)

    def __enter__(self) -> "Sticks":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._done.set()
        self._thread.join()

    def hold(self, *, forward: float = 0.0, up: float = 0.0) -> None:
        """Hold the sticks there, centred where nothing is said; -1..1."""
        self._axes = (forward, 0.0, (up + 1.0) / 2.0, 0.0)

    def _send(self) -> None:
        while not self._done.wait(1.0 / STICKS_HZ):
            self._control.set_manual_control_input(*self._axes)
