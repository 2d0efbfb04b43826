"""Turn the heading asked for smoothly: limited rate and acceleration, as PX4's automatic modes do.

A yaw loop with PX4's gains overshoots a sudden step by a quarter of it; a smooth turn it follows.
"""

import math

from sitl.autopilot.control.trajectory import TICK_S
from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.frames import wrap_pi

STEP_RAD = math.radians(5.0)  # assumption: a stream that moves less from one to the next is smooth
BRAKING_SHARE = 0.7  # of the greatest acceleration, planned for coming to rest
ARRIVAL_GAIN = 2.0  # 1/s, rate per heading left in the last degrees
ARRIVED_RAD = 1e-4


class Heading:
    """A heading on its way to another."""

    def __init__(self, parameters: Parameters) -> None:
        self.yaw_rad = self.rate_rad_s = 0.0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take limits from the parameters."""
        self._rate_max = math.radians(parameters["MPC_YAWRAUTO_MAX"])
        self._acceleration = math.radians(parameters["MPC_YAWRAUTO_ACC"])

    def start(self, yaw_rad: float) -> None:
        """Stand still at a heading."""
        self.yaw_rad, self.rate_rad_s = yaw_rad, 0.0

    @property
    def rest_rad(self) -> float:
        """Where the turn ends if it is given up now."""
        rate = self.rate_rad_s
        return wrap_pi(self.yaw_rad + 0.5 * rate * abs(rate) / self._acceleration)

    def turn(self, wanted_rad: float) -> None:
        """Move by one tick towards a heading, to stand still there."""
        left = wrap_pi(wanted_rad - self.yaw_rad)
        size, step = abs(left), self._acceleration * TICK_S
        if size <= ARRIVED_RAD and abs(self.rate_rad_s) <= step:
            self.start(wanted_rad)
            return
        braking = math.sqrt(2.0 * BRAKING_SHARE * self._acceleration * size)
        rate = min(braking, ARRIVAL_GAIN * size, self._rate_max)
        change = math.copysign(rate, left) - self.rate_rad_s
        self.rate_rad_s += min(max(change, -step), step)
        self.yaw_rad = wrap_pi(self.yaw_rad + self.rate_rad_s * TICK_S)

    def follow(self, wanted_rad: float) -> None:
        """Move by one tick with a stream: what moves little by little is taken as it is."""
        if self.rate_rad_s == 0.0 and abs(wrap_pi(wanted_rad - self.yaw_rad)) <= STEP_RAD:
            self.yaw_rad = wanted_rad
        else:
            self.turn(wanted_rad)


class Facing:
    """Judges whether a vehicle that has arrived faces as it was asked to.

    As with PX4's navigator, it waits without MIS_YAW_TMT for the heading, however long that takes.
    With it, only headings that are forced are waited for: those of a LOITER_TIME whose second
    parameter is above 0. When that takes longer, the mission has failed.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take limits from the parameters."""
        self._error_rad = math.radians(parameters["MIS_YAW_ERR"])
        self._timeout_us = parameters["MIS_YAW_TMT"] * SECOND_US

    def accepts(self, wanted_rad: float, yaw_rad: float, *, forced: bool = False) -> bool:
        """Say whether a heading will do; NaN is wanted where any does."""
        if math.isnan(wanted_rad) or (self._timeout_us > 0.0 and not forced):
            return True
        return abs(wrap_pi(wanted_rad - yaw_rad)) < self._error_rad

    def gives_up(self, waited_us: int) -> bool:
        """Say whether a forced heading has been waited for too long."""
        return 0.0 < self._timeout_us <= waited_us
