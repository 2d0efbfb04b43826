"""Turn to a heading smoothly: limited rate and acceleration, as PX4's automatic modes do.

A yaw loop with PX4's gains overshoots a sudden step by a quarter of it; a smooth turn it follows.
"""

import math
from typing import NamedTuple, Self

from sitl.autopilot.control.arithmetic import clamp
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US, TICK_S
from sitl.frames import wrap_pi

STEP_RAD = math.radians(5.0)  # assumption: a stream that moves less from one to the next is smooth
BRAKING_SHARE = 0.7  # of the acceleration limit, planned for coming to rest
ARRIVAL_GAIN = 2.0  # 1/s, rate per heading left in the last degrees
ARRIVED_RAD = 1e-4


class HeadingParameters(NamedTuple):
    """How briskly a heading turns."""

    rate_max_rad_s: float  # MPC_YAWRAUTO_MAX
    acceleration_rad_s2: float  # MPC_YAWRAUTO_ACC

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            rate_max_rad_s=math.radians(values["MPC_YAWRAUTO_MAX"]),
            acceleration_rad_s2=math.radians(values["MPC_YAWRAUTO_ACC"]),
        )


class Heading(NamedTuple):
    """A heading on its way to another."""

    yaw_rad: float = 0.0
    rate_rad_s: float = 0.0

    def rest_rad(self, parameters: HeadingParameters) -> float:
        """Where the turn ends if it is given up now."""
        rate = self.rate_rad_s
        return wrap_pi(self.yaw_rad + 0.5 * rate * abs(rate) / parameters.acceleration_rad_s2)

    def turn(self, target_rad: float, parameters: HeadingParameters) -> "Heading":
        """Move by one tick towards a heading, to stand still there."""
        yaw, rate = self
        rate_max, acceleration = parameters
        left = wrap_pi(target_rad - yaw)
        size, step = abs(left), acceleration * TICK_S
        if size <= ARRIVED_RAD and abs(rate) <= step:
            return Heading(target_rad)
        braking = math.sqrt(2.0 * BRAKING_SHARE * acceleration * size)
        new_rate = min(braking, ARRIVAL_GAIN * size, rate_max)
        change = math.copysign(new_rate, left) - rate
        rate += clamp(change, step)
        return Heading(wrap_pi(yaw + rate * TICK_S), rate)

    def follow(self, target_rad: float, parameters: HeadingParameters) -> "Heading":
        """Move by one tick with a stream: what moves little by little is taken as it is."""
        if self.rate_rad_s == 0.0 and abs(wrap_pi(target_rad - self.yaw_rad)) <= STEP_RAD:
            return Heading(target_rad)
        return self.turn(target_rad, parameters)


class FacingParameters(NamedTuple):
    """Whether a vehicle that has arrived faces as it was told to.

    As with PX4's navigator, it waits without MIS_YAW_TMT for the heading, however long that takes.
    With it, only headings that are forced are waited for: those of a LOITER_TIME whose second
    parameter is above 0. When that takes longer, the mission has failed.
    """

    error_max_rad: float  # MIS_YAW_ERR
    timeout_us: float  # MIS_YAW_TMT; not above 0: none

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            error_max_rad=math.radians(values["MIS_YAW_ERR"]),
            timeout_us=values["MIS_YAW_TMT"] * SECOND_US,
        )

    def accepts(self, target_rad: float, yaw_rad: float, *, forced: bool = False) -> bool:
        """Say whether a heading will do; NaN where any does."""
        if math.isnan(target_rad) or (self.timeout_us > 0.0 and not forced):
            return True
        return abs(wrap_pi(target_rad - yaw_rad)) < self.error_max_rad

    def gives_up(self, waited_us: int) -> bool:
        """Say whether a forced heading has been waited for too long."""
        return 0.0 < self.timeout_us <= waited_us
