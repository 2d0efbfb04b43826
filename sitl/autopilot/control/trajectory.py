"""Smooth motion for the automatic modes: limited speed, acceleration and jerk, axis by axis."""

import math
from typing import NamedTuple

from sitl.autopilot.control.arithmetic import clamp
from sitl.clock import TICK_S
from sitl.records.motion import Vector3

SNAP = 2.0  # ticks of jerk within which a speed counts as reached
LAG_MAX_M = 2.0  # PX4 MPC_XY_ERR_MAX: the motion waits for a vehicle further behind than this
# Found by simulating moves of 0.5 to 30 m: with these an approach neither overshoots nor crawls.
DISTANCE_GAIN = 1.5  # 1/s, speed per distance in the last metre
SPEED_GAIN = 2.0  # 1/s, acceleration per missing speed
BRAKING_SHARE = 0.5  # of the greatest acceleration, planned for braking


class Agility(NamedTuple):
    """How briskly to move."""

    acceleration_m_s2: float
    jerk_m_s3: float


class Axis:
    """Position, velocity and acceleration of one axis.

    Plain attributes: frozen records would cost the three axes 0.7 us of a tick's 24.
    """

    __slots__ = ("acceleration", "position", "velocity")

    def __init__(self, position: float, velocity: float, acceleration: float) -> None:
        self.position = position
        self.velocity = velocity
        self.acceleration = acceleration

    def lead(self, speed: float, agility: Agility) -> None:
        """Advance one tick towards a speed, so that it is reached with no acceleration left."""
        limit, jerk = agility
        missing = speed - self.velocity
        step = jerk * TICK_S
        if abs(missing) <= SNAP * step * TICK_S and abs(self.acceleration) <= SNAP * step:
            self.velocity, self.acceleration = speed, 0.0
            self.position += speed * TICK_S
        else:
            target = min(math.sqrt(2.0 * jerk * abs(missing)), limit)
            self._accelerate(math.copysign(target, missing), jerk)

    def follow(self, speed: float, feed_forward: float, agility: Agility) -> None:
        """Advance one tick along a speed that changes by `feed_forward` (m/s2)."""
        limit, jerk = agility
        target = feed_forward + SPEED_GAIN * (speed - self.velocity)
        self._accelerate(clamp(target, limit), jerk)

    def _accelerate(self, target: float, jerk: float) -> None:
        step = jerk * TICK_S
        self.acceleration += clamp(target - self.acceleration, step)
        self.velocity += self.acceleration * TICK_S
        self.position += self.velocity * TICK_S


class Trajectory:
    """A point that moves through NED as the vehicle should."""

    def __init__(self, position: Vector3, velocity: Vector3, acceleration: Vector3) -> None:
        self.north, self.east, self.down = (
            Axis(p, v, a) for p, v, a in zip(position, velocity, acceleration, strict=True)
        )

    def stop_xy(self, agility: Agility) -> None:
        """Advance one tick of coming to a horizontal stop."""
        self.north.lead(0.0, agility)
        self.east.lead(0.0, agility)

    def approach_xy(self, x: float, y: float, cruise_m_s: float, agility: Agility) -> None:
        """Advance one tick of a straight way to a place."""
        north, east = self.north, self.east
        dx, dy = x - north.position, y - east.position
        distance = math.hypot(dx, dy)
        ux, uy = (dx / distance, dy / distance) if distance > 1e-9 else (0.0, 0.0)
        speed, slope = speed_along_way(distance, cruise_m_s, agility)
        closing = ux * north.velocity + uy * east.velocity
        north.follow(ux * speed, -ux * closing * slope, agility)
        east.follow(uy * speed, -uy * closing * slope, agility)

    def approach_z(self, z: float, speed_max_m_s: float, agility: Agility) -> None:
        """Advance one tick of the way to a height."""
        left = z - self.down.position
        speed, slope = approach_speed(abs(left), speed_max_m_s, agility)
        feed_forward = -self.down.velocity * slope
        self.down.follow(math.copysign(speed, left), feed_forward, agility)

    def relocate(self, position: Vector3) -> None:
        """Put the point elsewhere, at rest."""
        for axis, value in zip((self.north, self.east, self.down), position, strict=True):
            axis.position, axis.velocity, axis.acceleration = value, 0.0, 0.0

    def lags(self, position: Vector3) -> bool:
        """Whether the vehicle is so far behind, horizontally, that the point must wait."""
        x, y = self.north.position - position[0], self.east.position - position[1]
        return x * x + y * y > LAG_MAX_M**2

    @property
    def position(self) -> Vector3:
        """Where the point is, m."""
        return (self.north.position, self.east.position, self.down.position)

    @property
    def velocity(self) -> Vector3:
        """How fast it moves, m/s."""
        return (self.north.velocity, self.east.velocity, self.down.velocity)

    @property
    def acceleration(self) -> Vector3:
        """How it speeds up, m/s2."""
        return (self.north.acceleration, self.east.acceleration, self.down.acceleration)


def speed_along_way(distance_m: float, speed_max: float, agility: Agility) -> tuple[float, float]:
    """Give the horizontal speed at a distance from the place to stop at, and its slope over it.

    The speed v from which PX4's motion planning brakes obeys v^2 + 4 v a^2 / j = 2 a d: it leaves
    so much room for the jerk that the last metres take their time.
    """
    acceleration, jerk = agility
    half = 2.0 * acceleration * acceleration / jerk
    root = math.sqrt(half * half + 2.0 * acceleration * distance_m)
    speed = root - half
    return (speed, acceleration / root) if speed < speed_max else (speed_max, 0.0)


def approach_speed(distance_m: float, speed_max: float, agility: Agility) -> tuple[float, float]:
    """Give the speed at a distance from which one can stop, and its slope over the distance.

    Braking from v at the deceleration a, built up and let go at the jerk limit j, takes
    v^2 / 2a + v a / 2j. Near the target the speed falls in proportion to the distance.
    """
    braking = BRAKING_SHARE * agility.acceleration_m_s2
    half = braking * braking / (2.0 * agility.jerk_m_s3)
    root = math.sqrt(half * half + 2.0 * braking * distance_m)
    speed, slope = root - half, braking / root
    if DISTANCE_GAIN * distance_m < speed:
        speed, slope = DISTANCE_GAIN * distance_m, DISTANCE_GAIN
    return (speed, slope) if speed < speed_max else (speed_max, 0.0)
