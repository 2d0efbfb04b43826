"""Flight by sticks in Altitude and Position."""

import math

import pytest

from sitl.records.modes import Mode
from sitl.records.vehicle import Sticks
from tests.unit.sitl.autopilot.conftest import Flight

ARM, ACCEPTED, REJECTED = 400, 0, 1
ALTCTL, POSCTL = 2, 3


class Pilot:
    """Holds the sticks; they are sent at 25 Hz."""

    def __init__(self, flight: Flight) -> None:
        self.flight = flight
        self.axes = {"forward": 0.0, "right": 0.0, "up": 0.0, "turn": 0.0}

    def hold(self, seconds: float, **axes: float) -> None:
        """Keep the sticks in a place, centred where none is named."""
        axes = dict.fromkeys(self.axes, 0.0) | axes
        for _ in range(round(seconds * 25)):
            time_us = self.flight.time_us
            self.flight.autopilot.manual_control(Sticks(time_us=time_us, **axes))
            self.flight.run(0.04)


@pytest.fixture
def pilot(flight: Flight) -> Pilot:
    """A pilot whose vehicle hovers at 10 m in Position."""
    flight.place((0.0, 0.0, -10.0))
    pilot = Pilot(flight)
    pilot.hold(0.1)
    assert flight.autopilot.set_mode(POSCTL, 0).result == ACCEPTED
    pilot.hold(1.0)
    flight.texts.clear()
    return pilot


@pytest.mark.parametrize("mode", [ALTCTL, POSCTL])
def test_without_sticks_their_modes_are_not_available_in_flight(flight: Flight, mode: int) -> None:
    flight.place((0.0, 0.0, -10.0))
    flight.run(0.5)
    assert flight.autopilot.set_mode(mode, 0).result == REJECTED


def test_a_full_stick_flies_forward_at_the_manual_speed(pilot: Pilot) -> None:
    pilot.flight.parameters.set("MPC_VEL_MANUAL", 4.0)
    pilot.hold(5.0, forward=1.0)
    assert pilot.flight.estimate.velocity_ned[0] == pytest.approx(4.0, rel=0.05)
    assert abs(pilot.flight.estimate.velocity_ned[1]) < 0.1
    assert pilot.flight.height_m == pytest.approx(10.0, abs=0.2)


def test_sticks_turn_with_the_vehicle(pilot: Pilot) -> None:
    pilot.hold(2.0, turn=0.6)
    pilot.hold(1.0)
    heading = pilot.flight.autopilot.yaw_rad
    assert heading != 0.0
    pilot.hold(2.0, right=0.7)
    vx, vy, _ = pilot.flight.estimate.velocity_ned
    assert math.atan2(vy, vx) == pytest.approx(heading + math.pi / 2, abs=0.1)


def test_centred_sticks_stop_and_hold_the_place(pilot: Pilot) -> None:
    pilot.hold(3.0, forward=0.6)
    pilot.hold(5.0)
    here = pilot.flight.estimate.position_ned
    pilot.hold(5.0)
    assert math.dist(pilot.flight.estimate.position_ned, here) < 0.05


def test_speed_grows_no_faster_than_the_limits_allow(pilot: Pilot) -> None:
    pilot.hold(1.0, forward=1.0)
    assert pilot.flight.estimate.velocity_ned[0] < 3.0 * 1.0  # MPC_ACC_HOR


@pytest.mark.parametrize(("stick", "speed"), [(1.0, -3.0), (-1.0, 1.5)])
def test_throttle_climbs_and_descends_at_its_limits(
    pilot: Pilot, stick: float, speed: float
) -> None:
    pilot.hold(2.5, up=stick)
    assert pilot.flight.estimate.velocity_ned[2] == pytest.approx(speed, rel=0.08)


def test_small_movements_of_the_sticks_do_nothing(pilot: Pilot) -> None:
    pilot.hold(3.0, forward=0.09, right=-0.09, up=0.09, turn=0.09)
    assert math.dist(pilot.flight.estimate.position_ned, (0.0, 0.0, -10.0)) < 0.05
    assert abs(pilot.flight.autopilot.yaw_rad) < 0.01


def test_a_turned_stick_gives_the_yaw_rate_of_its_shape(pilot: Pilot) -> None:
    pilot.hold(2.0, turn=0.55)
    half = 0.4 * 0.5 + 0.6 * 0.5**3  # MPC_YAW_EXPO 0.6 beyond a dead zone of 0.1
    expected = math.radians(150.0) * half
    assert pilot.flight.estimate.rates_frd[2] == pytest.approx(expected, rel=0.1)  # PX4: 0.95


def test_in_altitude_a_full_stick_is_the_tilt_limit(pilot: Pilot) -> None:
    assert pilot.flight.autopilot.set_mode(ALTCTL, 0).result == ACCEPTED
    pilot.hold(1.0, right=1.0)
    w, x, y, z = pilot.flight.estimate.q_ned_frd
    tilt = math.acos(1.0 - 2.0 * (x * x + y * y))
    assert math.degrees(tilt) == pytest.approx(35.0, abs=2.0)
    assert pilot.flight.height_m == pytest.approx(10.0, abs=0.4)
    pilot.hold(1.0)
    assert math.hypot(*pilot.flight.estimate.velocity_ned[:2]) > 3.0  # it drifts on
    assert (w, z) != (0.0, 0.0)


def test_take_off_and_land_by_sticks(flight: Flight) -> None:
    pilot = Pilot(flight)
    pilot.hold(1.2)
    assert flight.autopilot.set_mode(POSCTL, 0).result == ACCEPTED
    assert flight.autopilot.status.armable
    assert flight.command(ARM, 1.0) == ACCEPTED
    pilot.hold(2.0)
    assert flight.autopilot.status.landed_state == 1
    pilot.hold(6.0, up=0.7)
    assert flight.height_m > 2.0
    pilot.hold(3.0)
    assert flight.autopilot.status.landed_state == 2
    pilot.hold(14.0, up=-1.0)
    assert not flight.autopilot.status.armed
    assert flight.said[-1] == "6:Disarmed by landing"


def test_lost_sticks_hold_then_return(pilot: Pilot) -> None:
    pilot.flight.run(0.6)
    assert pilot.flight.autopilot.status.mode is Mode.HOLD  # within COM_FAIL_ACT_T
    assert pilot.flight.autopilot.status.failsafe
    pilot.flight.run(5.0)
    assert pilot.flight.autopilot.status.mode is Mode.RTL


def test_sticks_that_come_back_in_time_fly_again(pilot: Pilot) -> None:
    pilot.flight.run(2.0)
    pilot.hold(1.0)
    assert pilot.flight.autopilot.status.mode is Mode.POSCTL
    assert not pilot.flight.autopilot.status.failsafe


def test_the_loss_is_noted_within_a_tick_of_its_time(pilot: Pilot) -> None:
    lost_s = pilot.flight.run_until(lambda: pilot.flight.autopilot.status.failsafe, timeout_s=1.0)
    assert 0.5 - 0.04 <= lost_s <= 0.5 - 0.04 + 2 * 0.004  # COM_RC_LOSS_T after the last message


@pytest.mark.parametrize("source", [0, 4])
def test_sticks_over_mavlink_can_be_switched_off(flight: Flight, source: int) -> None:
    flight.parameters.set("COM_RC_IN_MODE", source)
    flight.place((0.0, 0.0, -10.0))
    pilot = Pilot(flight)
    pilot.hold(0.2)
    assert flight.autopilot.set_mode(POSCTL, 0).result == REJECTED


def test_without_a_position_the_sticks_go_on_in_altitude(pilot: Pilot) -> None:
    pilot.flight.change = lambda estimate: estimate._replace(position_valid=False)
    pilot.hold(0.2)
    assert pilot.flight.autopilot.status.mode is Mode.ALTCTL
    pilot.flight.change = lambda estimate: estimate
    pilot.hold(0.2)
    assert pilot.flight.autopilot.status.mode is Mode.POSCTL
