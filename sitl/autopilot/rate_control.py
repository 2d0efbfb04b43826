"""Body rate control: PID on each axis, D on the measured angular acceleration."""

import math

from sitl.autopilot.low_pass import low_pass_gain
from sitl.autopilot.parameters import Parameters
from sitl.records import Vector3

INTEGRAL_FADE_RAD_S = math.radians(400.0)  # PX4: errors of this size don't integrate at all


class RateControl:
    """Turns a body rate error into normalised torques, -1..1."""

    def __init__(self, parameters: Parameters) -> None:
        self._integral = [0.0, 0.0, 0.0]
        self._acceleration = [0.0, 0.0, 0.0]  # rad/s2, low-passed
        self._previous: Vector3 | None = None
        self._yaw_torque = 0.0
        self._dt_s = 0.0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take gains and limits from the parameters."""
        p = parameters
        self._gains = tuple(
            (
                p[f"MC_{axis}RATE_P"],
                p[f"MC_{axis}RATE_I"],
                p[f"MC_{axis}RATE_D"],
                p[f"MC_{axis[0]}R_INT_LIM"],
            )
            for axis in ("ROLL", "PITCH", "YAW")
        )
        self._cutoffs_hz = (p["IMU_DGYRO_CUTOFF"], p["MC_YAW_TQ_CUTOFF"])
        self._dt_s = 0.0

    def reset(self) -> None:
        """Forget the past, as PX4 does while disarmed."""
        self._integral = [0.0, 0.0, 0.0]
        self._acceleration = [0.0, 0.0, 0.0]
        self._previous = None
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
        previous = self._previous or rates
        self._previous = rates
        integral, acceleration, torque = self._integral, self._acceleration, [0.0, 0.0, 0.0]
        for axis in (0, 1, 2):
            p, i, d, limit = self._gains[axis]
            acceleration[axis] += self._d_gain * (
                (rates[axis] - previous[axis]) / dt_s - acceleration[axis]
            )
            error = wanted[axis] - rates[axis]
            torque[axis] = p * error + integral[axis] - d * acceleration[axis]
            if not landed and error * saturated[axis] <= 0.0:
                fade = max(0.0, 1.0 - (error / INTEGRAL_FADE_RAD_S) ** 2)
                value = integral[axis] + fade * i * error * dt_s
                integral[axis] = min(max(value, -limit), limit)
        # The slow yaw torque is smoothed: rotors give it through their drag.
        self._yaw_torque += self._yaw_gain * (torque[2] - self._yaw_torque)
        return (
            min(max(torque[0], -1.0), 1.0),
            min(max(torque[1], -1.0), 1.0),
            min(max(self._yaw_torque, -1.0), 1.0),
        )
