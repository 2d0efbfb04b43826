"""Body rate control: PID on each axis, D on the measured angular acceleration."""

import math
from typing import NamedTuple, Self

from sitl.autopilot.control.arithmetic import clamp
from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import TICK_S
from sitl.records.motion import Vector3

INTEGRAL_FADE_RAD_S = math.radians(400.0)  # PX4: errors of this size don't integrate at all


class AxisGains(NamedTuple):
    """PID of one axis, and how large its integral may grow."""

    p: float
    i: float
    d: float
    integral_max: float

    @classmethod
    def resolve(cls, values: ParameterValues, axis: str) -> Self:
        """Take PX4's values of ROLL, PITCH or YAW."""
        p, i, d = (values[f"MC_{axis}RATE_{letter}"] for letter in "PID")
        return cls(p, i, d, integral_max=values[f"MC_{axis[0]}R_INT_LIM"])


class RateParameters(NamedTuple):
    """How hard an error of the body rates is met."""

    roll: AxisGains  # MC_ROLLRATE_P, _I, _D, MC_RR_INT_LIM
    pitch: AxisGains  # MC_PITCHRATE_P, _I, _D, MC_PR_INT_LIM
    yaw: AxisGains  # MC_YAWRATE_P, _I, _D, MC_YR_INT_LIM
    derivative_gain: float  # of the low pass, IMU_DGYRO_CUTOFF
    yaw_torque_gain: float  # of the low pass, MC_YAW_TQ_CUTOFF

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(
            roll=AxisGains.resolve(values, "ROLL"),
            pitch=AxisGains.resolve(values, "PITCH"),
            yaw=AxisGains.resolve(values, "YAW"),
            derivative_gain=low_pass_gain(values["IMU_DGYRO_CUTOFF"]),
            yaw_torque_gain=low_pass_gain(values["MC_YAW_TQ_CUTOFF"]),
        )


class RateControl:
    """Turns a body rate error into normalised torques, -1..1."""

    def __init__(self) -> None:
        self._axes = (RateAxis(), RateAxis(), RateAxis())
        self._yaw_torque = 0.0

    def reset(self) -> None:
        """Forget the past, as PX4 does while disarmed."""
        for axis in self._axes:
            axis.reset()
        self._yaw_torque = 0.0

    def update(
        self,
        rates: Vector3,
        setpoint: Vector3,
        parameters: RateParameters,
        *,
        saturated: Vector3,
        landed: bool,
    ) -> Vector3:
        """Advance by one tick; `saturated` is the sign of the torque that the mixer had to cut."""
        (roll, pitch, yaw), learns = self._axes, not landed
        gains_r, gains_p, gains_y, low_pass, yaw_low_pass = parameters
        p, q, r = rates
        p_to, q_to, r_to = setpoint
        x = roll.update(p, p_to - p, gains_r, low_pass, learns=learns, saturated=saturated[0])
        y = pitch.update(q, q_to - q, gains_p, low_pass, learns=learns, saturated=saturated[1])
        z = yaw.update(r, r_to - r, gains_y, low_pass, learns=learns, saturated=saturated[2])
        # The slow yaw torque is smoothed: rotors give it through their drag.
        z = self._yaw_torque = self._yaw_torque + yaw_low_pass * (z - self._yaw_torque)
        return (clamp(x, 1.0), clamp(y, 1.0), clamp(z, 1.0))


class RateAxis:
    """What one axis remembers: its integral, and angular acceleration (rad/s2, low-passed).

    Plain attributes: frozen records would cost each tick 1.0 us of its 24.
    """

    __slots__ = ("_acceleration", "_integral", "_previous")

    def __init__(self) -> None:
        self._integral = self._acceleration = 0.0
        self._previous: float | None = None

    def reset(self) -> None:
        """Forget the past."""
        self._integral = self._acceleration = 0.0
        self._previous = None

    def update(
        self,
        rate: float,
        error: float,
        gains: AxisGains,
        low_pass: float,
        *,
        learns: bool,
        saturated: float,
    ) -> float:
        """Give the torque; `low_pass` is the gain of the acceleration's filter."""
        previous = rate if self._previous is None else self._previous
        self._previous = rate
        acceleration = self._acceleration
        acceleration += low_pass * ((rate - previous) / TICK_S - acceleration)
        self._acceleration = acceleration
        p, i, d, integral_max = gains
        integral = self._integral
        if learns and error * saturated <= 0.0:
            fade = 1.0 - (error / INTEGRAL_FADE_RAD_S) ** 2
            if fade > 0.0:
                self._integral = clamp(integral + fade * i * error * TICK_S, integral_max)
        return p * error + integral - d * acceleration
