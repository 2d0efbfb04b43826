"""Failsafes in flight: each acts within its delay and one tick, and recovers as PX4's do."""

import pytest

from sitl.records.modes import Mode
from sitl.records.sensing import Estimate
from sitl.records.vehicle import Sticks
from tests.unit.sitl.autopilot.conftest import Flight

TICK_S = 0.004
ARM = 400
AXES = ("forward", "right", "up", "turn")


@pytest.fixture
def hovering(flight: Flight) -> Flight:
    """A vehicle in HOLD at 10 m."""
    flight.place((0.0, 0.0, -10.0))
    flight.autopilot.set_mode(4, 3)
    flight.run(1.0)
    flight.texts.clear()
    return flight


def seconds_until(flight: Flight, mode: Mode, timeout_s: float = 20.0) -> float:
    return flight.run_until(lambda: flight.autopilot.status.mode is mode, timeout_s=timeout_s)


def drain_to(flight: Flight, charge: float) -> None:
    flight.change = lambda estimate: estimate._replace(battery=charge)


def test_a_ground_station_never_seen_is_not_missed(hovering: Flight) -> None:
    hovering.parameters.set("NAV_DLL_ACT", 2)
    hovering.run(12.0)
    assert hovering.autopilot.status.mode is Mode.HOLD
    assert hovering.said == []


def test_loss_of_the_ground_station_returns_after_its_delays(hovering: Flight) -> None:
    hovering.parameters.set("NAV_DLL_ACT", 2)
    hovering.autopilot.ground_station_heard()
    lost_s = hovering.run_until(lambda: hovering.autopilot.status.failsafe, timeout_s=20.0)
    assert 10.0 <= lost_s <= 10.0 + 2 * TICK_S  # COM_DL_LOSS_T, and the tick that notes it
    assert hovering.autopilot.status.system_status == 5
    assert 5.0 - TICK_S <= seconds_until(hovering, Mode.RTL) <= 5.0 + TICK_S
    assert hovering.said[:2] == [
        "2:Failsafe activated: entering Hold for 5 seconds",
        "2:No connection to the ground control station: Return in 5 s",
    ]
    hovering.autopilot.ground_station_heard()
    hovering.run(0.1)
    assert hovering.autopilot.status.mode is Mode.RTL  # until the user says otherwise
    hovering.autopilot.set_mode(4, 3)
    hovering.run(0.1)
    assert (hovering.autopilot.status.mode, hovering.autopilot.status.failsafe) == (
        Mode.HOLD,
        False,
    )


def test_by_default_the_loss_of_the_ground_station_does_nothing(hovering: Flight) -> None:
    hovering.autopilot.ground_station_heard()
    hovering.run(11.0)
    assert not hovering.autopilot.status.failsafe


def test_a_silent_companion_is_told_of_and_nothing_more(hovering: Flight) -> None:
    hovering.autopilot.companion_heard()
    hovering.run(5.1)
    assert hovering.said == ["4:Connection to mission computer lost"]
    assert not hovering.autopilot.status.failsafe
    hovering.autopilot.companion_heard()
    hovering.run(0.1)
    assert hovering.said[1:] == ["4:Connection to mission computer regained"]


@pytest.mark.parametrize(("charge", "mode"), [(0.069, Mode.RTL), (0.049, Mode.LAND)])
def test_a_battery_at_its_end_brings_the_vehicle_down_after_the_hold(
    hovering: Flight, charge: float, mode: Mode
) -> None:
    drain_to(hovering, charge)
    assert hovering.run_until(lambda: hovering.autopilot.status.failsafe, timeout_s=1.0) <= (
        2 * TICK_S
    )
    assert 5.0 - TICK_S <= seconds_until(hovering, mode) <= 5.0 + TICK_S


def test_a_low_battery_is_told_of(hovering: Flight) -> None:
    drain_to(hovering, 0.149)
    hovering.run(6.0)
    assert hovering.said == ["4:Low battery level, return advised"]
    assert hovering.autopilot.status.battery_warning == 1
    assert hovering.autopilot.status.mode is Mode.HOLD


def test_the_user_may_go_on_with_an_empty_battery(hovering: Flight) -> None:
    drain_to(hovering, 0.06)
    seconds_until(hovering, Mode.RTL)
    hovering.autopilot.set_mode(4, 3)
    hovering.run(6.0)
    assert hovering.autopilot.status.mode is Mode.HOLD
    drain_to(hovering, 0.04)
    hovering.run(6.0)
    assert hovering.autopilot.status.mode is Mode.HOLD  # the same cause, overridden


def test_no_arming_with_a_low_battery(flight: Flight) -> None:
    drain_to(flight, 0.1)
    flight.run(1.1)
    assert flight.command(400, 1.0) == 1
    assert not flight.autopilot.status.armable


@pytest.mark.parametrize("sensor", ["gyro", "accelerometer", "magnetometer", "barometer"])
def test_no_arming_without_a_sensor(flight: Flight, sensor: str) -> None:
    def fail(estimate: Estimate) -> Estimate:
        return estimate._replace(sensors=estimate.sensors._replace(**{sensor: False}))

    flight.change = fail
    flight.run(1.1)
    assert flight.command(400, 1.0) == 1


def test_without_a_position_the_vehicle_descends_level_and_lands(hovering: Flight) -> None:
    hovering.change = lambda estimate: estimate._replace(position_valid=False)
    assert seconds_until(hovering, Mode.LAND, timeout_s=1.0) <= 2 * TICK_S
    hovering.run(3.0)
    assert hovering.said[:2] == ["2:Failsafe activated", "2:No valid estimate"]
    assert 0.6 < hovering.estimate.velocity_ned[2] < 1.6
    hovering.run_until(lambda: not hovering.autopilot.status.armed, timeout_s=25.0)


def test_a_position_that_comes_back_lets_the_vehicle_hold_again(hovering: Flight) -> None:
    hovering.change = lambda estimate: estimate._replace(position_valid=False)
    hovering.run(1.0)
    hovering.change = lambda estimate: estimate
    hovering.run(0.1)
    assert (hovering.autopilot.status.mode, hovering.autopilot.status.failsafe) == (
        Mode.HOLD,
        False,
    )


def test_without_an_attitude_the_flight_is_terminated(hovering: Flight) -> None:
    hovering.change = lambda estimate: estimate._replace(attitude_valid=False)
    hovering.run(0.02)
    assert hovering.autopilot.status.mode is Mode.TERMINATION
    assert hovering.autopilot.status.system_status == 8


def test_a_parameter_acts_at_once_on_what_has_already_happened(hovering: Flight) -> None:
    hovering.autopilot.ground_station_heard()
    hovering.run(10.5)
    assert not hovering.autopilot.status.failsafe
    hovering.parameters.set("NAV_DLL_ACT", 1)
    hovering.run(0.02)
    assert hovering.autopilot.status.failsafe


@pytest.mark.parametrize("pause_s", [0.0, 0.1])
def test_sticks_that_were_lost_before_arming_are_not_missed(flight: Flight, pause_s: float) -> None:
    flight.run(1.1)
    flight.autopilot.manual_control(Sticks(time_us=flight.time_us, **dict.fromkeys(AXES, 0.0)))
    assert flight.command(ARM, 1.0) == 0
    flight.run(1.0)
    assert flight.autopilot.status.failsafe
    flight.command(ARM, 0.0)
    flight.run(pause_s)  # none: disarmed and armed between two ticks
    flight.texts.clear()
    assert flight.command(ARM, 1.0) == 0
    flight.run(3.0)
    assert flight.said[-1] == "6:Armed by external command"
    assert not flight.autopilot.status.failsafe
