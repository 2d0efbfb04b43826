"""Arming, modes and their refusals, in PX4's words."""

import math

import pytest

from sitl.autopilot.command.checks import Health, can_arm, can_run
from sitl.records.modes import Mode
from sitl.records.vehicle import OffboardSetpoint
from tests.unit.sitl.autopilot.conftest import Flight

NAN = math.nan
ARM, SET_MODE, TAKEOFF, LAND, RETURN, TERMINATE = 400, 176, 22, 21, 20, 185
ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
ZERO = (0.0, 0.0, 0.0)


@pytest.fixture
def ready(flight: Flight) -> Flight:
    """A vehicle whose checks pass."""
    flight.run(1.1)
    flight.texts.clear()
    return flight


@pytest.fixture
def hovering(flight: Flight) -> Flight:
    """A vehicle in HOLD at 10 m."""
    flight.place((0.0, 0.0, -10.0))
    flight.autopilot.set_mode(4, 3)
    flight.run(1.0)
    flight.texts.clear()
    return flight


def test_not_armable_until_the_estimate_is_valid(flight: Flight) -> None:
    flight.run(0.5)
    assert flight.autopilot.status.system_status == 0
    assert flight.command(ARM, 1.0) == REJECTED
    flight.run(0.7)
    assert flight.said == [
        "2:Arming denied: Resolve system health failures first",
        "6:Ready for takeoff!",
    ]
    assert flight.autopilot.status.system_status == 3
    assert flight.autopilot.status.armable


def test_not_armable_until_the_estimate_has_settled() -> None:
    well = Health(attitude_valid=True, position_valid=True, altitude_valid=True)
    assert can_arm(Mode.HOLD, well)
    assert not can_arm(Mode.HOLD, well._replace(settled=False))
    assert can_run(Mode.HOLD, well._replace(settled=False))


def test_arm_once_and_again(ready: Flight) -> None:
    assert ready.command(ARM, 1.0) == ACCEPTED
    assert ready.command(ARM, 1.0) == ACCEPTED
    ready.run(0.01)
    assert ready.said == ["6:Armed by external command"]
    status = ready.autopilot.status
    assert (status.base_mode, status.system_status, status.armed) == (157, 4, True)


def test_forced_arming_still_runs_the_checks(flight: Flight) -> None:
    flight.run(0.1)
    assert flight.command(ARM, 1.0, 21196.0) == REJECTED


def test_disarm_on_the_ground_once_and_again(ready: Flight) -> None:
    ready.command(ARM, 1.0)
    ready.run(0.5)
    ready.texts.clear()
    assert ready.command(ARM, 0.0) == ACCEPTED
    assert ready.command(ARM, 0.0) == ACCEPTED
    ready.run(0.01)
    assert ready.said == ["6:Disarmed by external command"]
    assert ready.autopilot.status.actuator_outputs == (900, 900, 900, 900)


def test_other_arming_parameters_get_no_answer(ready: Flight) -> None:
    assert ready.command(ARM, 3.0) is None
    assert ready.command(ARM, NAN) is None
    ready.run(0.01)
    assert ready.said[0] == "2:Unsupported ARM_DISARM param: 3.000"
    assert not ready.autopilot.status.armed


def test_disarming_in_the_air_needs_force(hovering: Flight) -> None:
    assert hovering.command(ARM, 0.0) == REJECTED
    hovering.run(0.01)
    assert hovering.said == ["2:Disarming denied: not landed"]
    assert hovering.command(ARM, 0.0, 21196.0) == ACCEPTED
    hovering.run(0.01)
    status = hovering.autopilot.status
    assert (status.armed, status.mode, status.system_status) == (False, Mode.HOLD, 3)
    assert status.landed_state == 1


def test_idle_after_arming_disarms(ready: Flight) -> None:
    ready.command(ARM, 1.0)
    ready.run(9.9)
    assert ready.autopilot.status.armed
    ready.run(0.2)
    assert not ready.autopilot.status.armed
    assert ready.said[-1] == "6:Disarmed by auto preflight disarming"


def test_preflight_disarming_can_be_switched_off(ready: Flight) -> None:
    ready.parameters.set("COM_DISARM_PRFLT", -1.0)
    ready.command(ARM, 1.0)
    ready.run(12.0)
    assert ready.autopilot.status.armed


@pytest.mark.parametrize(
    "mode", [mode for mode in Mode if mode not in {Mode.TERMINATION}], ids=lambda mode: mode.name
)
def test_any_mode_is_taken_while_disarmed(ready: Flight, mode: Mode) -> None:
    main, sub, base = mode.value
    assert ready.command(SET_MODE, 1.0, main, sub) == ACCEPTED
    ready.run(0.01)
    status = ready.autopilot.status
    assert (status.mode, status.custom_mode) == (mode, main << 16 | sub << 24)
    assert status.base_mode == base
    assert status.system_status == (3 if mode in {Mode.HOLD, Mode.TAKEOFF} else 0)


@pytest.mark.parametrize("place", [(1e30, 8.5, 490.0), (47.4, -181.0, 490.0), (47.4, 8.5, 1e38)])
def test_a_take_off_leads_nowhere_but_over_earth(
    ready: Flight, place: tuple[float, float, float]
) -> None:
    assert ready.command(TAKEOFF, 0.0, 0.0, 0.0, math.nan, *place) == DENIED
    assert ready.command(TAKEOFF, 0.0, 0.0, 0.0, math.nan, 47.3977, 8.5456, 495.0) == ACCEPTED


def test_termination_is_no_mode_to_choose(ready: Flight) -> None:
    assert ready.command(SET_MODE, 1.0, 10.0, 0.0) == REJECTED
    assert ready.autopilot.status.mode is Mode.HOLD


def test_a_termination_is_final(flight: Flight) -> None:
    """PX4 never changes out of it, and does not arm in it."""
    flight.place((0.0, 0.0, -30.0))
    flight.send(velocity_ned=(0.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(0.1)
    assert flight.command(TERMINATE, 1.0) == ACCEPTED
    flight.run(0.1)
    for main, sub in ((4.0, 3.0), (4.0, 6.0), (6.0, 0.0)):
        assert flight.command(SET_MODE, 1.0, main, sub) == REJECTED
    for command in (TAKEOFF, LAND, RETURN):
        assert flight.command(command, *[math.nan] * 7) == REJECTED
    flight.run(0.1)
    status = flight.autopilot.status
    assert (status.mode, status.system_status, status.throttle) == (Mode.TERMINATION, 8, 0.0)
    assert flight.command(ARM, 0.0, 21196.0) == ACCEPTED  # disarmed by force
    flight.run(0.1)
    assert flight.autopilot.status.mode is Mode.TERMINATION
    assert flight.command(SET_MODE, 1.0, 4.0, 3.0) == REJECTED
    assert flight.command(ARM, 1.0) == REJECTED
    flight.run(0.1)
    assert not flight.autopilot.status.armed


def test_offboard_is_armable_with_setpoints_only(ready: Flight) -> None:
    ready.command(SET_MODE, 1.0, 6.0, 0.0)
    ready.run(0.1)
    assert (ready.autopilot.status.base_mode, ready.autopilot.status.system_status) == (1, 0)
    assert ready.command(ARM, 1.0) == REJECTED
    ready.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    ready.run(0.1)
    assert (ready.autopilot.status.base_mode, ready.autopilot.status.system_status) == (17, 3)
    assert ready.command(ARM, 1.0) == ACCEPTED
    ready.run(0.1)
    assert (ready.autopilot.status.base_mode, ready.autopilot.status.system_status) == (145, 4)


@pytest.mark.parametrize(
    ("main", "sub", "name"),
    [
        (1, 0, "Manual"),
        (2, 0, "Altitude"),
        (3, 0, "Position"),
        (4, 4, "Mission"),
        (6, 0, "Offboard"),
    ],
)
def test_modes_that_cannot_run_are_refused_in_flight(
    hovering: Flight, main: int, sub: int, name: str
) -> None:
    hovering.run(1.5)  # the last setpoint is old
    assert hovering.command(SET_MODE, 1.0, main, sub) == REJECTED
    hovering.run(0.01)
    assert hovering.said == [f"2:Switching to {name} is currently not available"]
    assert hovering.autopilot.status.mode is Mode.HOLD


@pytest.mark.parametrize("params", [(1.0, 99.0, 0.0), (0.0, 4.0, 6.0), (1.0, NAN, NAN)])
def test_senseless_modes_are_accepted_and_ignored(
    hovering: Flight, params: tuple[float, float, float]
) -> None:
    assert hovering.command(SET_MODE, *params) == ACCEPTED
    hovering.run(0.1)
    assert hovering.autopilot.status.mode is Mode.HOLD
    assert hovering.said == []


def test_offboard_can_be_chosen_right_after_the_first_setpoint(hovering: Flight) -> None:
    hovering.run(1.5)  # the last setpoint is old
    assert hovering.command(SET_MODE, 1.0, 6.0, 0.0) == REJECTED
    hovering.autopilot.offboard_setpoint(
        OffboardSetpoint(time_us=hovering.time_us, velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    )
    assert hovering.command(SET_MODE, 1.0, 6.0, 0.0) == ACCEPTED


def test_take_off_while_disarmed_waits_for_arming(ready: Flight) -> None:
    assert ready.command(TAKEOFF) == ACCEPTED
    ready.run(0.1)
    status = ready.autopilot.status
    assert (status.mode, status.armed) == (Mode.TAKEOFF, False)
    ready.command(ARM, 1.0)
    ready.run(12.0)
    assert ready.height_m == pytest.approx(2.55, abs=0.05)


def test_land_is_always_accepted(ready: Flight) -> None:
    assert ready.command(LAND) == ACCEPTED
    ready.run(0.1)
    assert ready.autopilot.status.mode is Mode.LAND


def test_after_a_landing_out_of_offboard_the_mode_is_offboard_again(flight: Flight) -> None:
    flight.place((0.0, 0.0, -1.0))
    flight.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    flight.run(1.0)
    flight.stream = None
    flight.command(LAND)
    flight.run_until(lambda: not flight.autopilot.status.armed, timeout_s=15.0)
    status = flight.autopilot.status
    assert (status.mode, status.system_status) == (Mode.OFFBOARD, 0)


def test_flight_termination(hovering: Flight) -> None:
    assert hovering.command(185, 1.0) == ACCEPTED
    hovering.run(0.1)
    assert hovering.autopilot.status.system_status == 8
    assert hovering.autopilot.status.throttle == 0.0


def test_commands_that_it_does_not_do(ready: Flight) -> None:
    assert ready.command(185, 1.0) == DENIED  # termination while disarmed
    assert ready.command(300) == DENIED  # no mission to start
    assert ready.command(246, 99.0) == DENIED
    assert ready.command(31999) == UNSUPPORTED


def test_home_is_where_it_was_armed_or_where_it_was_put(ready: Flight) -> None:
    assert ready.autopilot.status.home_valid
    assert ready.command(179, 0.0, 0.0, 0.0, 0.0, 47.398, 8.5456, 490.0) == ACCEPTED
    ready.run(0.1)
    north, _, down = ready.autopilot.status.home_ned
    assert north == pytest.approx(math.radians(47.398 - 47.397742) * 6371000.0)
    assert down == pytest.approx(-0.6)
    assert ready.command(179, 1.0) == ACCEPTED
    ready.run(0.1)
    assert ready.autopilot.status.home_ned == pytest.approx(ready.estimate.position_ned, abs=1e-3)


@pytest.mark.parametrize("place", [(91.0, 8.5, 490.0), (47.4, 400.0, 490.0), (47.4, 8.5, 1e38)])
def test_home_is_nowhere_but_on_earth(ready: Flight, place: tuple[float, float, float]) -> None:
    before = ready.autopilot.status.home_ned
    assert ready.command(179, 0.0, 0.0, 0.0, 0.0, *place) == DENIED
    ready.run(0.1)
    assert ready.autopilot.status.home_ned == before


def test_idle_setpoint_is_what_px4_shows_on_the_ground(ready: Flight) -> None:
    echo = ready.autopilot.setpoint_echo
    assert echo.type_mask == 63
    assert echo.acceleration_ned == (0.0, 0.0, 100.0)


def test_velocity_setpoint_is_echoed_with_its_mask(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(velocity_ned=(1.0, 0.5, -0.2), yaw_rate_rad_s=0.1)
    flight.run(0.2)
    echo = flight.autopilot.setpoint_echo
    assert echo.type_mask == 7
    assert echo.velocity_ned == (1.0, 0.5, -0.2)
    assert echo.yaw_rate_rad_s == 0.1
