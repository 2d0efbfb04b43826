"""How far the estimate is from the truth: slow errors, as a Kalman filter leaves them.

Velocity errors are first-order Gauss-Markov processes. A position error is the integral of the
velocity error, pulled back by the aiding sensor: so the two belong together, as in a filter.
Heading and tilt errors are Gauss-Markov processes of their own. Without its aid an error is not
pulled back: heading walks, and the tilt error's share of gravity accelerates the estimate.
The sizes are assumptions, set so that a hover wanders as a running PX4 was seen to: by 0.2 to 0.3 m
horizontally over minutes, with a velocity that is good to 0.1 m/s.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from sitl.clock import SECOND_US, TICK_S
from sitl.frames import GRAVITY_M_S2
from sitl.records.motion import Quaternion, Vector3


class Process(NamedTuple):
    """A first-order Gauss-Markov process, one step per tick."""

    std: float
    time_constant_s: float

    @property
    def decay(self) -> float:
        """What is left of a value after one tick."""
        return math.exp(-TICK_S / self.time_constant_s)

    @property
    def kick(self) -> float:
        """The standard deviation of what chance adds in one tick."""
        return self.std * math.sqrt(1.0 - self.decay**2)


VELOCITY_XY = Process(0.06, 2.0)  # m/s
VELOCITY_Z = Process(0.02, 3.0)
PULL_XY_S, PULL_Z_S = 6.0, 10.0  # time constants by which aiding pulls the position back
TILT = Process(math.radians(0.15), 5.0)
HEADING = Process(math.radians(1.0), 30.0)
HEADING_WALK = math.radians(0.05) * math.sqrt(TICK_S)  # without magnetometer: 0.4 deg in a minute

XY_DECAY, XY_KICK = VELOCITY_XY.decay, VELOCITY_XY.kick
Z_DECAY, Z_KICK = VELOCITY_Z.decay, VELOCITY_Z.kick
TILT_DECAY, TILT_KICK = TILT.decay, TILT.kick
HEADING_DECAY, HEADING_KICK = HEADING.decay, HEADING.kick
PULL_XY, PULL_Z = 1.0 - TICK_S / PULL_XY_S, 1.0 - TICK_S / PULL_Z_S


class Drift:
    """The errors of position and velocity (NED) and of the attitude (small angles about NED)."""

    def __init__(self, noise: Iterator[float]) -> None:
        self.aided_m = AIDED_M  # spread of the position's errors, horizontal and vertical
        self._noise = noise
        self._tilt = (TILT.std * next(noise), TILT.std * next(noise))
        self._heading = HEADING.std * next(noise)
        self._vx, self._x = _draw(VELOCITY_XY, PULL_XY_S, noise)
        self._vy, self._y = _draw(VELOCITY_XY, PULL_XY_S, noise)
        self._vz, self._z = _draw(VELOCITY_Z, PULL_Z_S, noise)

    def restart_xy(self) -> None:
        """Forget a position that has run away: the filter starts anew from the receiver."""
        self._vx, self._x = _draw(VELOCITY_XY, PULL_XY_S, self._noise)
        self._vy, self._y = _draw(VELOCITY_XY, PULL_XY_S, self._noise)

    def advance(self, *, xy_aided: bool, z_aided: bool, heading_aided: bool) -> None:
        """Move by one tick."""
        noise = self._noise
        roll, pitch = self._tilt
        roll = TILT_DECAY * roll + TILT_KICK * next(noise)
        pitch = TILT_DECAY * pitch + TILT_KICK * next(noise)
        self._tilt = (roll, pitch)
        kick_x, kick_y = XY_KICK * next(noise), XY_KICK * next(noise)
        if xy_aided:
            self._vx = XY_DECAY * self._vx + kick_x
            self._vy = XY_DECAY * self._vy + kick_y
            self._x = PULL_XY * self._x + TICK_S * self._vx
            self._y = PULL_XY * self._y + TICK_S * self._vy
        else:
            self._vx -= TICK_S * GRAVITY_M_S2 * pitch
            self._vy += TICK_S * GRAVITY_M_S2 * roll
            self._x += TICK_S * self._vx
            self._y += TICK_S * self._vy
        self._vz = (Z_DECAY if z_aided else 1.0) * self._vz + Z_KICK * next(noise)
        self._z = (PULL_Z if z_aided else 1.0) * self._z + TICK_S * self._vz
        self._advance_heading(aided=heading_aided)

    def _advance_heading(self, *, aided: bool) -> None:
        if aided:
            self._heading = HEADING_DECAY * self._heading + HEADING_KICK * next(self._noise)
        else:
            self._heading += HEADING_WALK * next(self._noise)

    @property
    def position_ned(self) -> Vector3:
        """Estimate minus truth, m."""
        return (self._x, self._y, self._z)

    @property
    def velocity_ned(self) -> Vector3:
        """Estimate minus truth, m/s."""
        return (self._vx, self._vy, self._vz)

    def turn(self, q_ned_frd: Quaternion) -> Quaternion:
        """Turn a true attitude by the attitude's error, to first order."""
        w, x, y, z = q_ned_frd
        a, b, c = 0.5 * self._tilt[0], 0.5 * self._tilt[1], 0.5 * self._heading
        w, x, y, z = (
            w - a * x - b * y - c * z,
            x + a * w + b * z - c * y,
            y + b * w + c * x - a * z,
            z + c * w + a * y - b * x,
        )
        shrink = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
        return (w * shrink, x * shrink, y * shrink, z * shrink)


def accuracy_m(xy_unaided_us: int, z_unaided_us: int) -> tuple[float, float]:
    """Give the spread of the errors, horizontal and vertical, after a time without aid."""
    if xy_unaided_us == 0 and z_unaided_us == 0:
        return AIDED_M
    horizontal, vertical = AIDED_M
    seconds = xy_unaided_us / SECOND_US
    fall = 0.5 * GRAVITY_M_S2 * TILT.std * seconds * seconds
    horizontal = math.hypot(horizontal, math.sqrt(2.0) * (VELOCITY_XY.std * seconds + fall))
    vertical = math.hypot(vertical, VELOCITY_Z.std * z_unaided_us / SECOND_US)
    return horizontal, vertical


def _draw(velocity: Process, pull_s: float, noise: Iterator[float]) -> tuple[float, float]:
    """Draw a velocity error and a position error as they are after a long time."""
    return velocity.std * next(noise), position_std(velocity, pull_s) * next(noise)


def position_std(velocity: Process, pull_s: float) -> float:
    """Give the spread of a position error whose velocity error is that process."""
    share = velocity.time_constant_s / (velocity.time_constant_s + pull_s)
    return velocity.std * pull_s * math.sqrt(share)


AIDED_M = (
    math.sqrt(2.0) * position_std(VELOCITY_XY, PULL_XY_S),
    position_std(VELOCITY_Z, PULL_Z_S),
)
