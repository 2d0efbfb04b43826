"""Limits of our own: how high, how far and how fast, whatever the pilot asks.

A command is shortened so that the vehicle can stop before the limit: at a distance d from it no
faster than sqrt(2 a d). What is measured outside has the vehicle held, then landed.
"""

import math
from dataclasses import dataclass

from flightstack.errors import UsageError
from flightstack.mavlink.offboard import Velocities
from flightstack.mavlink.telemetry import Telemetry

BRAKING_M_S2 = 3.0  # PX4 MPC_ACC_HOR
SLACK_M = 0.5  # an estimate may err so far
UNKNOWN_HEIGHT_M = 3.0  # as of a vehicle that has just taken off
FASTER, SLACK_M_S = 1.25, 1.0  # than was allowed: a gust, an overshoot


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLimits:
    """How far a flight may go; heights are above home, distance is horizontal from there."""

    min_height_m: float = 0.3
    max_height_m: float = 50.0
    max_distance_m: float = 300.0
    max_speed_m_s: float = 12.0  # horizontal; PX4 MPC_XY_VEL_MAX
    max_climb_m_s: float = 5.0
    max_descent_m_s: float = 5.0

    def __post_init__(self) -> None:
        """Check once."""
        if self.min_height_m >= self.max_height_m:
            raise UsageError(
                f"--min-height {self.min_height_m:g} must lie below "
                f"--max-height {self.max_height_m:g}"
            )

    def clip(self, velocities: Velocities, vehicle: Telemetry) -> Velocities:
        """Shorten a command to what is allowed where the vehicle is."""
        forward, right, down, yaw_rate = velocities
        height_m, distance_m = place(vehicle)
        speed_m_s = math.hypot(forward, right)
        allowed_m_s = min(self.max_speed_m_s, stopping_speed(self.max_distance_m - distance_m))
        if speed_m_s > allowed_m_s:
            forward, right = (allowed_m_s / speed_m_s * part for part in (forward, right))
        climb_m_s = min(self.max_climb_m_s, stopping_speed(self.max_height_m - height_m))
        descent_m_s = min(self.max_descent_m_s, stopping_speed(height_m - self.min_height_m))
        return (forward, right, min(max(down, -climb_m_s), descent_m_s), yaw_rate)

    def breach(self, vehicle: Telemetry) -> str | None:
        """Say which limit the vehicle has passed, or reached its distance; None inside."""
        if vehicle.position_ned is None or vehicle.velocity_ned is None:
            return None
        height_m, distance_m = place(vehicle)
        north, east, down = vehicle.velocity_ned
        speed_m_s = math.hypot(north, east)
        breaches = (
            (height_m < self.min_height_m - SLACK_M, f"{height_m:.1f} m high", "--min-height"),
            (height_m > self.max_height_m + SLACK_M, f"{height_m:.1f} m high", "--max-height"),
            (
                distance_m > self.max_distance_m - SLACK_M,
                f"{distance_m:.1f} m from home",
                "--max-distance",
            ),
            (
                _is_too_fast(speed_m_s, self.max_speed_m_s),
                f"{speed_m_s:.1f} m/s fast",
                "--max-speed",
            ),
            (
                _is_too_fast(-down, self.max_climb_m_s),
                f"climbing at {-down:.1f} m/s",
                "--max-climb",
            ),
            (
                _is_too_fast(down, self.max_descent_m_s),
                f"sinking at {down:.1f} m/s",
                "--max-descent",
            ),
        )
        return next((f"is {words}: {name}" for broken, words, name in breaches if broken), None)


def place(vehicle: Telemetry) -> tuple[float, float]:
    """Return height above home and horizontal distance from it, m; home and 3 m if unknown."""
    if vehicle.position_ned is None:
        return UNKNOWN_HEIGHT_M, 0.0
    home_ned = vehicle.home_ned or (0.0, 0.0, 0.0)
    north, east, down = (a - b for a, b in zip(vehicle.position_ned, home_ned, strict=True))
    return -down, math.hypot(north, east)


def stopping_speed(distance_m: float) -> float:
    """Return the speed (m/s) from which the vehicle stops within a distance."""
    return math.sqrt(2.0 * BRAKING_M_S2 * max(0.0, distance_m))


def _is_too_fast(speed_m_s: float, allowed_m_s: float) -> bool:
    return speed_m_s > FASTER * allowed_m_s + SLACK_M_S
