"""Body rate control: PID on each axis, D on the measured angular acceleration."""

import math

from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.parameters import Parameters
from sitl.records.motion import Vector3

INTEGRAL_FADE_RAD_S = math.radians(400.0)  # PX4: errors of this size don't integrate at all


class RateControl:
    """Turns a body rate error into normalised torques, -1..1."""

    def __init__(self, parameters: Parameters) -> None:
        self._axes = (_Axis(), _Axis(), _Axis())
        self._yaw_torque = 0.0
        self._dt_s = 0.0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take gains and limits from the parameters."""
        p = parameters
        for axis, name in zip(self._axes, ("ROLL", "PITCH", "YAW"), strict=True):
            axis.p, axis.i, axis.d = (p[f"MC_{name}RATE_{letter}"] for letter in "PID")
            axis.limit = p[f"MC_{name[0]}R_INT_LIM"]
        self._cutoffs_hz = (p["IMU_DGYRO_CUTOFF"], p["MC_YAW_TQ_CUTOFF"])
        self._dt_s = 0.0

    def reset(self) -> None:
        """Forget the past, as PX4 does while disarmed."""
        for axis in self._axes:
            axis.reset()
        self._yaw_torque = 0.0

    def update(
        self,
        rates: Vector3,
        wanted: Vector3,
        dt_s: float,
        *,
        saturated: Vector3,
        landed: bool,
    ) -> Vector3:
        """Advance by one tick; `saturated` is the sign of the torque that the mixer had to cut."""
        if dt_s != self._dt_s:
            self._dt_s = dt_s
            self._d_gain, self._yaw_gain = (low_pass_gain(f, dt_s) for f in self._cutoffs_hz)
        (roll, pitch, yaw), gain, learns = self._axes, self._d_gain, not landed
        x = roll.update(rates[0], wanted[0], dt_s, gain, learns=learns, saturated=saturated[0])
        y = pitch.update(rates[1], wanted[1], dt_s, gain, learns=learns, saturated=saturated[1])
        z = yaw.update(rates[2], wanted[2], dt_s, gain, learns=learns, saturated=saturated[2])
        # The slow yaw torque is smoothed: rotors give it through their drag.
        z = self._yaw_torque = self._yaw_torque + self._yaw_gain * (z - self._yaw_torque)
        return (_limit(x, 1.0), _limit(y, 1.0), _limit(z, 1.0))


class _Axis:
    """One axis' controller: its gains, integral, and angular acceleration (rad/s2, low-passed)."""

    __slots__ = ("_acceleration", "_integral", "_previous", "d", "i", "limit", "p")

    def __init__(self) -> None:
        self.p = self.i = self.d = self.limit = 0.0
        self.reset()

    def reset(self) -> None:
        self._integral = self._acceleration = 0.0
        self._previous: float | None = None

    def update(
        self,
        rate: float,
        wanted: float,
        dt_s: float,
        gain: float,
        *,
        learns: bool,
        saturated: float,
    ) -> float:
        """Give the torque; `gain` is that of the acceleration's low pass."""
        previous = rate if self._previous is None else self._previous
        self._previous = rate
        acceleration = self._acceleration
        acceleration += gain * ((rate - previous) / dt_s - acceleration)
        self._acceleration = acceleration
        error, integral = wanted - rate, self._integral
        if learns and error * saturated <= 0.0:
            fade = 1.0 - (error / INTEGRAL_FADE_RAD_S) ** 2
            if fade > 0.0:
                self._integral = _limit(integral + fade * self.i * error * dt_s, self.limit)
        return self.p * error + integral - self.d * acceleration


def _limit(value: float, most: float) -> float:
    """Keep within -most..most; NaN stays."""
    return -most if value < -most else most if value > most else value
