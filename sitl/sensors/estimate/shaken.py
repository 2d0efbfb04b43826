"""The estimate's errors where turning rotors shake the inertial unit as in PX4's simulator (SIH).

They are those of a Kalman filter in its steady state, without the filter: the unit's noise turns
the attitude and drives the velocity away, as it does in a filter that integrates it; a tilt error
accelerates the estimate by its share of gravity; the velocity error moves the position; and the
receiver pulls all three back. The filter reckons with less noise than there is, and so pulls too
weakly: velocity is off by 0.12 m/s forward, 0.25 m/s sideways and 0.14 m/s down, for seconds, and a
hover wanders by 0.2 m, as a running PX4 was seen to. All of it takes the place of `Drift`'s errors
of position, velocity and tilt: with a share below some 0.3 velocity is finer than on a fine day.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from sitl.clock import TICK_S
from sitl.frames import GRAVITY_M_S2
from sitl.records.motion import Vector3
from sitl.sensors.estimate.drift import Drift

ZERO: Vector3 = (0.0, 0.0, 0.0)


class Pull(NamedTuple):
    """What aiding takes off an error per second, for each unit of the velocity's and position's.

    That is the filter's gain, a minute after it began, times the measurements per second. Source:
    PX4's defaults EKF2_ACC_NOISE 0.35, EKF2_GYR_NOISE 0.015, EKF2_ACC_B_NOISE 0.003,
    EKF2_GYR_B_NOISE 0.001, EKF2_BARO_NOISE 3.5 (at 20 Hz), a filter step of 10 ms, and the accuracy
    that its simulated receiver tells at 8 Hz: 0.4 m/s (vertically taken 1.5 fold), 0.9 m, 1.78 m.
    """

    by_velocity: float
    by_position: float


XY_POSITION, XY_VELOCITY = Pull(0.66, 0.40), Pull(0.47, 0.123)
XY_TILT = Pull(0.0126, 0.00215)  # rad
Z_POSITION, Z_VELOCITY = Pull(0.30, 0.31), Pull(0.123, 0.055)
LEVELLING_S = 5.0  # assumption: without the receiver, gravity pulls the tilt back

# What the noise brings the errors to: root mean square of the two horizontal axes, then vertical.
POSITION_STD_M, VELOCITY_STD_M_S = (0.133, 0.241), (0.196, 0.143)
TILT_STD_RAD = math.radians(0.70)


class ShakenDrift(Drift):
    """Errors of position, velocity and tilt that grow out of what the inertial unit misreads."""

    def __init__(self, noise: Iterator[float], *, share: float) -> None:
        """Take a share, 0 to 1, of the noise into the estimate."""
        self._share = share
        self._specific_force_ned = self._rates_ned = ZERO
        self.z_deriv_m_s = 0.0  # how fast the position's error grows, down
        super().__init__(noise)
        self._tilt = self._draw_tilt()
        self._vx, self._x = self._draw_axis(0)
        self._vy, self._y = self._draw_axis(0)
        self._vz, self._z = self._draw_axis(1)
        horizontal, vertical = POSITION_STD_M
        self.aided_m = (share * math.sqrt(2.0) * horizontal, share * vertical)

    def feel(self, specific_force_ned: Vector3, rates_ned: Vector3) -> None:
        """Take in by how much too much the inertial unit read, for the next tick."""
        share = self._share
        x, y, z = specific_force_ned
        self._specific_force_ned = (share * x, share * y, share * z)
        x, y, z = rates_ned
        self._rates_ned = (share * x, share * y, share * z)

    def restart(self, *, xy_aided: bool, z_aided: bool) -> None:
        """Start the filter anew, its inertial unit back: forget what is not lost for good.

        The heading's error stays, and so do those of velocity and position that nothing aids.
        """
        self._tilt = self._draw_tilt()
        if xy_aided:
            self.restart_xy()
        if z_aided:
            self._vz, self._z = self._draw_axis(1)

    def restart_xy(self) -> None:
        """Forget a position that has run away: the filter starts anew from the receiver."""
        self._vx, self._x = self._draw_axis(0)
        self._vy, self._y = self._draw_axis(0)

    def advance(self, *, xy_aided: bool, z_aided: bool, heading_aided: bool) -> None:
        """Move by one tick."""
        self._advance_xy(aided=xy_aided)
        self._advance_z(aided=z_aided)
        self._advance_heading(aided=heading_aided)

    def _advance_xy(self, *, aided: bool) -> None:
        x, y, vx, vy = self._x, self._y, self._vx, self._vy
        roll, pitch = self._tilt
        ax, ay, _ = self._specific_force_ned
        ax, ay = ax - GRAVITY_M_S2 * pitch, ay + GRAVITY_M_S2 * roll
        p, q, _ = self._rates_ned
        if not aided:
            self._x, self._y = x + TICK_S * vx, y + TICK_S * vy
            self._vx, self._vy = vx + TICK_S * ax, vy + TICK_S * ay
            self._tilt = (
                roll + TICK_S * (p - roll / LEVELLING_S),
                pitch + TICK_S * (q - pitch / LEVELLING_S),
            )
            return
        by_v, by_x = XY_POSITION
        self._x = x + TICK_S * (vx - by_v * vx - by_x * x)
        self._y = y + TICK_S * (vy - by_v * vy - by_x * y)
        by_v, by_x = XY_VELOCITY
        self._vx = vx + TICK_S * (ax - by_v * vx - by_x * x)
        self._vy = vy + TICK_S * (ay - by_v * vy - by_x * y)
        by_v, by_x = XY_TILT
        self._tilt = (
            roll + TICK_S * (p - by_v * vy - by_x * y),
            pitch + TICK_S * (q + by_v * vx + by_x * x),
        )

    def _advance_z(self, *, aided: bool) -> None:
        z, vz, down = self._z, self._vz, self._specific_force_ned[2]
        self.z_deriv_m_s = vz
        if not aided:
            self._z, self._vz = z + TICK_S * vz, vz + TICK_S * down
            return
        by_v, by_z = Z_POSITION
        self.z_deriv_m_s -= by_v * vz + by_z * z
        self._z = z + TICK_S * self.z_deriv_m_s
        by_v, by_z = Z_VELOCITY
        self._vz = vz + TICK_S * (down - by_v * vz - by_z * z)

    def _draw_tilt(self) -> tuple[float, float]:
        return self._draw(TILT_STD_RAD), self._draw(TILT_STD_RAD)

    def _draw_axis(self, index: int) -> tuple[float, float]:
        """Draw a velocity error and a position error, horizontal (0) or vertical (1)."""
        return self._draw(VELOCITY_STD_M_S[index]), self._draw(POSITION_STD_M[index])

    def _draw(self, std: float) -> float:
        return self._share * std * next(self._noise)
