"""Losing and regaining the stream of setpoints in flight, as PX4 was seen to handle it."""

import math

import pytest

from sitl.records.modes import Mode
from tests.unit.sitl.autopilot.conftest import Flight

NAN = math.nan
ZERO = (0.0, 0.0, 0.0)


def lose_stream(flight: Flight, height_m: float = 8.0) -> None:
    flight.place((0.0, 0.0, -height_m))
    flight.send(velocity_ned=(1.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(2.0)
    flight.stream = None


def seconds_since_last_setpoint(flight: Flight) -> float:
    newest_us = flight.autopilot._offboard._stream.newest_us
    assert newest_us is not None
    return (flight.time_us - newest_us) / 1e6


def test_failsafe_acts_within_a_tick_of_the_timeout(flight: Flight) -> None:
    lose_stream(flight)
    flight.run_until(lambda: flight.autopilot.status.failsafe, timeout_s=2.0)
    assert 1.0 <= seconds_since_last_setpoint(flight) <= 1.0 + 2 * 0.004
    assert flight.said[0] == "2:Failsafe activated"


@pytest.mark.parametrize("timeout_s", [0.3, 2.5])
def test_timeout_is_a_parameter(flight: Flight, timeout_s: float) -> None:
    flight.parameters.set("COM_OF_LOSS_T", timeout_s)
    lose_stream(flight)
    flight.run_until(lambda: flight.autopilot.status.failsafe, timeout_s=4.0)
    assert seconds_since_last_setpoint(flight) == pytest.approx(timeout_s, abs=0.009)


@pytest.mark.parametrize("handing_over", [0, 1, 2])
@pytest.mark.parametrize(("sticks_loss", "mode"), [(1, Mode.HOLD), (2, Mode.RTL), (3, Mode.LAND)])
def test_what_is_a_pilots_goes_by_the_loss_of_sticks_where_there_are_none(
    flight: Flight, handing_over: int, sticks_loss: int, mode: Mode
) -> None:
    flight.parameters.set("COM_OBL_RC_ACT", handing_over)
    flight.parameters.set("NAV_RCL_ACT", sticks_loss)
    lose_stream(flight)
    flight.run(1.2)
    status = flight.autopilot.status
    assert (status.mode, status.base_mode, status.system_status) == (mode, 157, 5)
    assert status.intended_mode is Mode.OFFBOARD


@pytest.mark.parametrize(
    ("action", "custom_mode", "base_mode"),
    [
        (3, 0x05040000, 157),
        (4, 0x06040000, 157),
        (5, 0x03040000, 157),
    ],
)
def test_action_is_a_parameter(
    flight: Flight, action: int, custom_mode: int, base_mode: int
) -> None:
    flight.parameters.set("COM_OBL_RC_ACT", action)
    lose_stream(flight)
    flight.run(1.2)
    status = flight.autopilot.status
    assert (status.custom_mode, status.base_mode, status.system_status) == (
        custom_mode,
        base_mode,
        5,
    )


def test_action_hold_stays_in_the_air(flight: Flight) -> None:
    flight.parameters.set("COM_OBL_RC_ACT", 5)
    lose_stream(flight)
    flight.run(10.0)
    assert flight.height_m == pytest.approx(8.0, abs=0.1)


def test_action_terminate_stops_the_rotors_for_good(flight: Flight) -> None:
    flight.parameters.set("COM_OBL_RC_ACT", 6)
    lose_stream(flight)
    flight.run(1.2)
    assert flight.autopilot.status.system_status == 8
    flight.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    flight.run(0.5)
    assert flight.autopilot.status.throttle == 0.0


def test_action_disarm_disarms(flight: Flight) -> None:
    flight.parameters.set("COM_OBL_RC_ACT", 7)
    lose_stream(flight)
    flight.run(1.2)
    status = flight.autopilot.status
    assert not status.armed
    assert not status.failsafe


def test_resumed_stream_resumes_offboard_without_a_word(flight: Flight) -> None:
    lose_stream(flight)
    flight.run(2.0)
    flight.texts.clear()
    flight.send(velocity_ned=(1.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(0.1)
    status = flight.autopilot.status
    assert (status.mode, status.base_mode, status.failsafe) == (Mode.OFFBOARD, 145, False)
    flight.run(3.0)
    assert flight.estimate.velocity_ned[0] == pytest.approx(1.0, abs=0.2)
    assert flight.said == []


@pytest.mark.parametrize("gap_s", [0.6, 0.8, 0.9])
def test_short_gaps_are_harmless(flight: Flight, gap_s: float) -> None:
    lose_stream(flight)
    flight.run(gap_s)
    flight.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    flight.run(1.0)
    assert flight.said == []
    assert flight.autopilot.status.mode is Mode.OFFBOARD


def test_the_user_can_leave_a_failsafe_for_hold(flight: Flight) -> None:
    lose_stream(flight)
    flight.run(1.5)
    assert flight.autopilot.set_mode(4, 3).result == 0
    flight.run(0.1)
    status = flight.autopilot.status
    assert (status.mode, status.failsafe, status.system_status) == (Mode.HOLD, False, 4)


def test_nan_velocity_brakes_and_stays_in_offboard(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(velocity_ned=(2.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(3.0)
    flight.send(velocity_ned=(NAN, NAN, 0.0), yaw_rate_rad_s=0.0)
    flight.run(4.0)
    assert flight.autopilot.status.mode is Mode.OFFBOARD
    assert math.hypot(*flight.estimate.velocity_ned) < 0.1
    assert flight.said == []
    flight.send(velocity_ned=(2.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(3.0)
    assert flight.estimate.velocity_ned[0] == pytest.approx(2.0, abs=0.2)


def test_nan_vertical_velocity_holds_height(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(velocity_ned=(0.0, 0.0, NAN), yaw_rate_rad_s=0.0)
    flight.run(4.0)
    assert flight.height_m == pytest.approx(5.0, abs=0.1)
