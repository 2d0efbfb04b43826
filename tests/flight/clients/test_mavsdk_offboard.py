"""Scenarios that PX4 publishes for MAVSDK: offboard by position and attitude, sticks, failures."""

import math
import threading
from functools import partial
from operator import eq
from pathlib import Path

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.failure import Failure, FailureError, FailureResult, FailureType, FailureUnit
from mavsdk.plugins.manual_control import ManualControl
from mavsdk.plugins.offboard import (
    Attitude,
    AttitudeRate,
    Offboard,
    PositionNedYaw,
    VelocityNedYaw,
)
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from tests.flight.clients.mavsdk_vehicle import (
    PATIENCE_S,
    Latest,
    Motion,
    Track,
    Vector3,
    found_vehicle,
)

pytestmark = pytest.mark.flight
LEG_S, WITHIN_M, HOME_M = 10.0, 0.3, 2.0  # PX4's own figures
RESTING_M_S = 0.5
HOVER_THRUST = 0.6
STICKS_SPEED_FACTOR = 2.0  # COM_RC_LOSS_T is then a quarter of a second of wall time
STICKS_HZ = 40.0


def test_offboard_by_position_velocity_and_attitude(system: System) -> None:
    telemetry, action, offboard = Telemetry(system), Action(system), Offboard(system)
    track = Track(telemetry)
    mode = Latest(telemetry.subscribe_flight_mode)
    state = Latest(telemetry.subscribe_landed_state)
    armed = Latest(telemetry.subscribe_armed)
    arm_when_healthy(telemetry, action)
    north, east, ground = track.now().place_ned

    offboard.set_position_ned(PositionNedYaw(north, east, ground - 3.0, 0.0))
    offboard.start()
    mode.until(lambda value: value == FlightMode.OFFBOARD, "offboard", timeout_s=5.0)
    for ahead, right in ((0.0, 0.0), (5.0, 0.0), (5.0, -5.0), (0.0, 0.0)):
        fly_leg(offboard, track, (north + ahead, east + right, ground - 4.0))
    fly_east(offboard, track)
    climb_by_attitude(offboard, track)
    turn_by_rate(offboard, telemetry)

    fly_leg(offboard, track, (north, east, ground - 2.0))
    action.land()
    for there in (LandedState.IN_AIR, LandedState.ON_GROUND):  # one after the other
        state.until(partial(eq, there), str(there), timeout_s=PATIENCE_S)
    for value in (True, False):
        armed.until(partial(eq, value), f"armed: {value}", timeout_s=PATIENCE_S)
    assert math.dist(track.now().place_ned, (north, east, ground)) < HOME_M


def fly_leg(offboard: Offboard, track: Track, place: Vector3) -> None:
    offboard.set_position_ned(PositionNedYaw(*place, 0.0))

    def has_come_to_stay(motion: Motion) -> bool:
        is_there = math.dist(motion.place_ned, place) < WITHIN_M
        return is_there and math.hypot(*motion.velocity_ned) < RESTING_M_S

    track.until(has_come_to_stay, f"staying at {place}", within_s=LEG_S)


def fly_east(offboard: Offboard, track: Track) -> None:
    """A velocity of the earth; the height is kept."""
    offboard.set_velocity_ned(VelocityNedYaw(0.0, 1.0, 0.0, 0.0))
    flown = track.wait(4.0)
    north, east, down = (
        after - before
        for before, after in zip(flown[0].place_ned, flown[-1].place_ned, strict=True)
    )
    assert 2.0 < east < 5.0
    assert max(abs(north), abs(down)) < 1.0
    assert flown[-1].velocity_ned[1] == pytest.approx(1.0, abs=0.4)


def climb_by_attitude(offboard: Offboard, track: Track) -> None:
    start = track.now().place_ned
    offboard.set_attitude(Attitude(0.0, 0.0, 0.0, HOVER_THRUST + 0.1))
    above = track.until(lambda m: m.place_ned[2] < start[2] - 2.0, "climbed", within_s=10.0)
    assert math.dist(above.place_ned[:2], start[:2]) < 5.0
    assert above.velocity_ned[2] < -0.5


def turn_by_rate(offboard: Offboard, telemetry: Telemetry) -> None:
    """Clockwise is positive."""
    heading = Latest(telemetry.subscribe_attitude_euler)
    before = heading.next().yaw_deg

    def turned_deg(angle_deg: float) -> float:
        return math.remainder(angle_deg - before, 360.0)

    offboard.set_attitude_rate(AttitudeRate(0.0, 0.0, 30.0, HOVER_THRUST))
    after = heading.until(lambda a: abs(turned_deg(a.yaw_deg)) > 15.0, "turned", timeout_s=10.0)
    assert turned_deg(after.yaw_deg) > 0.0


def test_position_control_by_sticks_and_refused_failure(tmp_path: Path) -> None:
    with found_vehicle(tmp_path, f"--speed-factor={STICKS_SPEED_FACTOR}") as system:
        refuse_failure(Failure(system))
        telemetry, action = Telemetry(system), Action(system)
        track = Track(telemetry)
        mode = Latest(telemetry.subscribe_flight_mode)
        armed = Latest(telemetry.subscribe_armed)
        sticks = ManualControl(system)
        with Sticks(sticks) as hands:
            track.wait(0.5)
            arm_when_healthy(telemetry, action)
            ground = track.now().place_ned[2]
            sticks.start_position_control()
            mode.until(lambda value: value == FlightMode.POSCTL, "position", timeout_s=5.0)
            fly_by_sticks(hands, track)
            hands.hold(up=-1.0)
            for value in (True, False):  # landed
                armed.until(partial(eq, value), f"armed: {value}", timeout_s=PATIENCE_S)
            assert track.now().place_ned[2] == pytest.approx(ground, abs=1.0)
            assert mode.next() == FlightMode.POSCTL


def fly_by_sticks(hands: "Sticks", track: Track) -> None:
    """Up, ahead, which is north, and to a rest that is kept."""
    start = track.now().place_ned
    hands.hold(up=1.0)
    above = track.until(lambda m: m.place_ned[2] < start[2] - 2.0, "up", within_s=10.0)
    assert math.dist(above.place_ned[:2], start[:2]) < 1.0
    hands.hold(forward=0.5)
    ahead = track.until(lambda m: m.place_ned[0] > start[0] + 3.0, "ahead", within_s=15.0)
    assert abs(ahead.place_ned[1] - start[1]) < 1.0
    hands.hold()
    at_rest = track.until(is_at_rest, "at rest", within_s=10.0)
    held = [motion.place_ned for motion in track.wait(2.0)]
    assert max(math.dist(place, at_rest.place_ned) for place in held) < 1.0


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


def is_at_rest(motion: Motion) -> bool:
    return math.hypot(*motion.velocity_ned) < 0.2


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
