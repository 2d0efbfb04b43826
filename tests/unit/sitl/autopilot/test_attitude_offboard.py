"""Offboard flight by attitude, by body rates, and by acceleration."""

import math

import pytest

from sitl.frames import euler_from_quaternion, quaternion_from_euler
from sitl.records.modes import Mode
from sitl.records.vehicle import AttitudeTarget, OffboardSetpoint
from tests.unit.sitl.autopilot.conftest import Flight

ZERO = (0.0, 0.0, 0.0)
LEVEL = (1.0, 0.0, 0.0, 0.0)
OFFBOARD = 6


def stream(
    flight: Flight,
    seconds: float,
    q: tuple[float, float, float, float] | None,
    thrust: float,
    rates: tuple[float, float, float] = ZERO,
) -> None:
    """Ask for an attitude (or rates) at 25 Hz."""
    for _ in range(round(seconds * 25)):
        flight.autopilot.attitude_setpoint(
            AttitudeTarget(time_us=flight.time_us, q_ned_frd=q, rates_frd=rates, thrust=thrust)
        )
        flight.run(0.04)


def tilt_deg(flight: Flight) -> tuple[float, float]:
    roll, pitch, _ = euler_from_quaternion(flight.estimate.q_ned_frd)
    return math.degrees(roll), math.degrees(pitch)


@pytest.fixture
def flying(flight: Flight) -> Flight:
    """A vehicle in OFFBOARD at 10 m."""
    flight.place((0.0, 0.0, -10.0))
    flight.run(0.1)
    return flight


def test_an_attitude_is_followed(flying: Flight) -> None:
    stream(flying, 1.0, quaternion_from_euler(0.1, -0.15, 0.5), flying.airframe.hover_thrust)
    assert tilt_deg(flying) == pytest.approx((math.degrees(0.1), math.degrees(-0.15)), abs=1.0)
    stream(flying, 2.0, quaternion_from_euler(0.1, -0.15, 0.5), flying.airframe.hover_thrust)
    assert flying.autopilot.yaw_rad == pytest.approx(0.5, abs=0.05)
    echo = flying.autopilot.setpoint_echo
    assert echo.thrust == flying.airframe.hover_thrust
    assert all(math.isnan(number) for number in echo.position_ned + echo.velocity_ned)


def test_more_thrust_than_hover_climbs(flying: Flight) -> None:
    stream(flying, 2.0, LEVEL, flying.airframe.hover_thrust + 0.1)
    assert flying.height_m > 11.0


def test_rates_are_followed(flying: Flight) -> None:
    stream(flying, 0.8, None, flying.airframe.hover_thrust, rates=(0.0, 0.0, 1.0))
    assert flying.estimate.rates_frd[2] == pytest.approx(1.0, abs=0.25)
    stream(flying, 0.2, None, flying.airframe.hover_thrust, rates=(0.5, 0.0, 0.0))
    assert flying.estimate.rates_frd[0] == pytest.approx(0.5, abs=0.1)


def test_take_off_by_attitude(flight: Flight) -> None:
    flight.run(1.1)
    stream(flight, 0.2, LEVEL, 0.0)
    flight.autopilot.set_mode(OFFBOARD, 0)
    assert flight.command(400, 1.0) == 0
    stream(flight, 2.0, LEVEL, 0.0)
    assert flight.autopilot.status.landed_state == 1
    stream(flight, 2.0, LEVEL, flight.airframe.hover_thrust + 0.1)
    assert flight.height_m > 0.5
    assert flight.autopilot.status.landed_state == 2


def test_the_stream_is_lost_as_any_other(flying: Flight) -> None:
    stream(flying, 1.0, LEVEL, flying.airframe.hover_thrust)
    flying.run(1.1)
    assert flying.autopilot.status.failsafe
    assert flying.autopilot.status.mode is Mode.RTL


def test_attitude_needs_no_position(flying: Flight) -> None:
    flying.change = lambda estimate: estimate._replace(position_valid=False)
    stream(flying, 1.0, LEVEL, flying.airframe.hover_thrust)
    assert flying.autopilot.status.mode is Mode.OFFBOARD
    flying.autopilot.offboard_setpoint(
        OffboardSetpoint(time_us=flying.time_us, velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    )
    flying.run(0.02)
    assert flying.autopilot.status.mode is Mode.LAND


def test_an_acceleration_is_followed(flying: Flight) -> None:
    flying.send(acceleration_ned=(1.0, 0.0, 0.0), yaw_rad=0.0)
    flying.run(2.0)
    assert flying.estimate.velocity_ned[0] == pytest.approx(1.7, abs=0.4)


def test_a_position_is_reached_and_held(flying: Flight) -> None:
    flying.send(position_ned=(5.0, -3.0, -8.0), yaw_rad=1.0)
    flying.run(8.0)
    assert math.dist(flying.estimate.position_ned, (5.0, -3.0, -8.0)) < 0.1
    assert flying.autopilot.yaw_rad == pytest.approx(1.0, abs=0.02)
