"""Smooth motion for the automatic modes: limited speed, acceleration and jerk, axis by axis."""

import math

from sitl.clock import SECOND_US, TICK_US
from sitl.records import Vector3

TICK_S = TICK_US / SECOND_US
SNAP = 2.0  # ticks of jerk within which a speed counts as reached
APPROACH_GAIN = 1.5  # 1/s, of the last metre
LAG_MAX_M = 2.0  # PX4 MPC_XY_ERR_MAX: the motion waits for a vehicle further behind than this


class Axis:
    """Position, velocity and acceleration of one axis, led towards a speed."""

    __slots__ = ("acceleration", "position", "velocity")

    def __init__(self, position: float, velocity: float, acceleration: float) -> None:
        self.position = position
        self.velocity = velocity
        self.acceleration = acceleration

    def lead(self, speed: float, acceleration_max: float, jerk: float) -> None:
        """Advance one tick towards a speed, so that it is reached with no acceleration left."""
        missing = speed - self.velocity
        step = jerk * TICK_S
        if abs(missing) <= SNAP * step * TICK_S and abs(self.acceleration) <= SNAP * step:
            self.velocity, self.acceleration = speed, 0.0
        else:
            wanted = min(math.sqrt(2.0 * jerk * abs(missing)), acceleration_max)
            change = math.copysign(wanted, missing) - self.acceleration
            self.acceleration += min(max(change, -step), step)
            self.velocity += self.acceleration * TICK_S
        self.position += self.velocity * TICK_S


class Trajectory:
    """A point that moves through NED as the vehicle should."""

    def __init__(self, position: Vector3, velocity: Vector3, acceleration: Vector3) -> None:
        self._axes = tuple(
            Axis(p, v, a) for p, v, a in zip(position, velocity, acceleration, strict=True)
        )

    def move(self, speeds: Vector3, accelerations: tuple[float, float], jerk: float) -> None:
        """Advance one tick towards a velocity, within (horizontal, vertical) accelerations."""
        north, east, down = self._axes
        north.lead(speeds[0], accelerations[0], jerk)
        east.lead(speeds[1], accelerations[0], jerk)
        down.lead(speeds[2], accelerations[1], jerk)

    def lags(self, position: Vector3) -> bool:
        """Whether the vehicle is so far behind, horizontally, that the point must wait."""
        north, east, _ = self._axes
        x, y = north.position - position[0], east.position - position[1]
        return x * x + y * y > LAG_MAX_M**2

    @property
    def position(self) -> Vector3:
        """Where the point is, m."""
        north, east, down = self._axes
        return (north.position, east.position, down.position)

    @property
    def velocity(self) -> Vector3:
        """How fast it moves, m/s."""
        north, east, down = self._axes
        return (north.velocity, east.velocity, down.velocity)

    @property
    def acceleration(self) -> Vector3:
        """How it speeds up, m/s2."""
        north, east, down = self._axes
        return (north.acceleration, east.acceleration, down.acceleration)


def approach_speed(distance_m: float, acceleration_max: float, jerk: float) -> float:
    """Give the speed from which one can stop within a distance, gently at its end.

    Braking from v at full deceleration a, built up and let go at the jerk limit j, takes
    v^2 / 2a + v a / 2j. Near the target the speed falls in proportion to the distance.
    """
    half = acceleration_max**2 / (2.0 * jerk)
    braking = math.sqrt(half * half + 2.0 * acceleration_max * distance_m) - half
    return min(braking, APPROACH_GAIN * distance_m)
