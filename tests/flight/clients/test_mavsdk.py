"""MAVSDK, written by others, takes off and holds, flies a square in offboard, stops and lands."""

import math
from functools import partial
from operator import eq
from pathlib import Path

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.offboard import Offboard, VelocityBodyYawspeed
from mavsdk.plugins.telemetry import FlightMode, LandedState, Telemetry

from tests.flight.clients.mavsdk_vehicle import PATIENCE_S, Latest, Track, found_vehicle
from tests.flight.tlogs import of_type, read, seconds_until

pytestmark = pytest.mark.flight
ARM, SET_MODE = 400, 176
HOLD = 0x03040000
WIDER = 0.15
# A real PX4 was seen, by MAVSDK:
IN_AIR_S = (1.8, 3.0)  # after arming; the earlier one on the other link
HEIGHT_M = (2.1, 2.9)
LEG_M = (1.2, 3.7)  # 3 s at 1 m/s
STOPPED_S = 1.0  # HOLD after 0.5 to 1.0 s, as its HEARTBEAT comes
LEG_S, STRAY_M = 3.0, 1.0


def test_takes_off_holds_flies_a_square_and_lands(tmp_path: Path) -> None:
    log = tmp_path / "vehicle.tlog"
    with found_vehicle(tmp_path, f"--log={log}") as system:
        fly(system)
    messages = read(log)
    orders = of_type(messages, "COMMAND_LONG")
    armed_s = next(m._timestamp for m in orders if m.command == ARM)
    in_air_s = seconds_until(
        messages, "EXTENDED_SYS_STATE", lambda m: m.landed_state in (2, 3), armed_s
    )
    low, high = IN_AIR_S
    assert low * (1.0 - WIDER) <= in_air_s <= high * (1.0 + WIDER)
    stopped_s = [m._timestamp for m in orders if m.command == SET_MODE][-1]
    held_s = seconds_until(messages, "HEARTBEAT", lambda m: m.custom_mode == HOLD, stopped_s)
    assert held_s <= STOPPED_S * (1.0 + WIDER)


def fly(system: System) -> None:
    telemetry, action, offboard = Telemetry(system), Action(system), Offboard(system)
    state = Latest(telemetry.subscribe_landed_state)
    mode = Latest(telemetry.subscribe_flight_mode)
    armed = Latest(telemetry.subscribe_armed)
    track = Track(telemetry)
    Latest(telemetry.subscribe_health_all_ok).until(bool, "healthy", timeout_s=20.0)
    ground = track.now().place_ned
    action.arm()
    action.takeoff()
    state.until(partial(eq, LandedState.IN_AIR), "in the air", timeout_s=PATIENCE_S)
    for expected in (FlightMode.TAKEOFF, FlightMode.HOLD):
        mode.until(partial(eq, expected), str(expected), timeout_s=PATIENCE_S)
    check_hold(track, ground)

    offboard.set_velocity_body(VelocityBodyYawspeed())
    offboard.start()
    mode.until(partial(eq, FlightMode.OFFBOARD), "offboard", timeout_s=5.0)
    start = track.now().place_ned
    for forward, right in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)):
        fly_leg(offboard, track, forward, right)
    end = track.now().place_ned
    assert max(abs(end[axis] - start[axis]) for axis in (0, 1)) < STRAY_M
    offboard.stop()
    mode.until(partial(eq, FlightMode.HOLD), "hold", timeout_s=5.0)

    action.land()
    state.until(partial(eq, LandedState.ON_GROUND), "landed", timeout_s=PATIENCE_S)
    for value in (True, False):  # one after the other
        armed.until(partial(eq, value), f"armed: {value}", timeout_s=PATIENCE_S)
    assert track.now().place_ned[2] == pytest.approx(ground[2], abs=STRAY_M)


def check_hold(track: Track, ground: tuple[float, float, float]) -> None:
    held = [motion.place_ned for motion in track.wait(3.0)]
    low, high = HEIGHT_M
    for place in (held[0], held[-1]):
        assert low * (1.0 - WIDER) <= ground[2] - place[2] <= high * (1.0 + WIDER)
    assert max(math.dist(held[0], place) for place in held) < STRAY_M


def fly_leg(offboard: Offboard, track: Track, forward: float, right: float) -> None:
    """Fly one side; the vehicle faces north, so forward is north and right is east."""
    before = track.now().place_ned
    offboard.set_velocity_body(VelocityBodyYawspeed(forward, right, 0.0, 0.0))
    track.wait(LEG_S)
    offboard.set_velocity_body(VelocityBodyYawspeed())
    rest = track.until(lambda m: math.hypot(*m.velocity_ned[:2]) < 0.1, "rest", within_s=10.0)
    north, east = (rest.place_ned[axis] - before[axis] for axis in (0, 1))
    low, high = LEG_M
    assert low * (1.0 - WIDER) <= forward * north + right * east <= high * (1.0 + WIDER)
    assert abs(right * north + forward * east) < STRAY_M
