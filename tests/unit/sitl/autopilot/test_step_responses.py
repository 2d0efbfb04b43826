"""Without noise, offboard velocity steps fall where a real PX4's do; with noise, see `sitl/`.

The bands were measured on PX4 1.17's SIH quadrotor with a drag of 0.1 N/(m/s) per kg, min..max of 4
(horizontal), 2 (vertical) and 6 (yaw) runs, and are widened by 15 % of their ends.
"""

import math
from collections.abc import Callable
from typing import Any

import pytest

from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from tests.unit.sitl.autopilot.conftest import Flight

WIDER = 0.15
PRE_STREAM_S = 1.008  # a whole number of ticks, and of setpoints


def band(low: float, high: float) -> tuple[float, float]:
    return (low * (1.0 - WIDER), high * (1.0 + WIDER))


def step_response(
    flight: Flight,
    velocity_ned: Vector3,
    yaw_rate_rad_s: float,
    seconds: float,
    speed: Callable[..., Any],
) -> tuple[list[float], list[float]]:
    """Times (s) and speeds as a share of the step, from a hover at 10 m."""
    flight.place((0.0, 0.0, -10.0))
    flight.send(velocity_ned=(0.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run(PRE_STREAM_S)
    flight.send(velocity_ned=velocity_ned, yaw_rate_rad_s=yaw_rate_rad_s)
    start_us, times, shares = flight.time_us, [], []
    while flight.time_us - start_us < seconds * 1e6:
        flight.step()
        times.append((flight.time_us - start_us) / 1e6)
        shares.append(speed(flight.estimate))
    return times, shares


def reach(times: list[float], shares: list[float], share: float) -> float:
    return next(time for time, value in zip(times, shares, strict=True) if value >= share)


def final(times: list[float], shares: list[float]) -> float:
    last = [value for time, value in zip(times, shares, strict=True) if time > times[-1] - 1.0]
    return sum(last) / len(last)


def assert_within(value: float, limits: tuple[float, float]) -> None:
    assert limits[0] <= value <= limits[1]


@pytest.mark.parametrize("speed", [1.0, 2.0])
@pytest.mark.parametrize("heading_rad", [0.0, 2.0])
def test_horizontal_step(flight: Flight, speed: float, heading_rad: float) -> None:
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)

    def share(estimate: Estimate) -> float:
        vx, vy, _ = estimate.velocity_ned
        return (vx * cos + vy * sin) / speed

    times, shares = step_response(flight, (speed * cos, speed * sin, 0.0), 0.0, 4.0, share)
    assert_within(reach(times, shares, 0.10), band(0.20, 0.32))
    assert_within(reach(times, shares, 0.632), band(0.64, 0.84))
    assert_within(reach(times, shares, 0.90), band(0.94, 1.22))
    assert_within(max(shares) - 1.0, band(0.07, 0.21))
    assert_within(final(times, shares), band(0.95, 1.15))


@pytest.mark.parametrize("velocity_down", [-1.0, -2.0, 1.0])
def test_vertical_step(flight: Flight, velocity_down: float) -> None:
    times, shares = step_response(
        flight,
        (0.0, 0.0, velocity_down),
        0.0,
        3.0,
        lambda estimate: estimate.velocity_ned[2] / velocity_down,
    )
    assert_within(reach(times, shares, 0.632), band(0.26, 0.30))
    assert_within(reach(times, shares, 0.90), band(0.42, 0.54))
    assert_within(final(times, shares), band(0.90, 1.05))


@pytest.mark.parametrize("yaw_rate", [0.5, -0.5])
def test_yaw_rate_step(flight: Flight, yaw_rate: float) -> None:
    times, shares = step_response(
        flight,
        (0.0, 0.0, 0.0),
        yaw_rate,
        4.0,
        lambda estimate: estimate.rates_frd[2] / yaw_rate,
    )
    assert_within(reach(times, shares, 0.632), band(0.45, 0.49))
    assert_within(final(times, shares), band(0.95, 0.96))
    turned_deg = math.degrees(sum(shares) / len(shares) * 4.0 * 0.5)
    assert_within(turned_deg, band(94.0, 96.0))


def test_speed_is_limited_to_the_parameter(flight: Flight) -> None:
    flight.parameters.set("MPC_XY_VEL_MAX", 5.0)
    times, speeds = step_response(
        flight, (20.0, 0.0, 0.0), 0.0, 8.0, lambda estimate: estimate.velocity_ned[0]
    )
    assert final(times, speeds) == pytest.approx(5.0, rel=0.06)
    assert flight.autopilot.setpoint_echo.velocity_ned[0] == 5.0


def test_forward_velocity_with_yaw_rate_holds_height(flight: Flight) -> None:
    flight.place((0.0, 0.0, -10.0))
    for _ in range(20):
        yaw = flight.autopilot.yaw_rad
        flight.send(velocity_ned=(math.cos(yaw), math.sin(yaw), 0.0), yaw_rate_rad_s=0.5)
        flight.run(0.2)
    assert flight.height_m == pytest.approx(10.0, abs=0.05)
