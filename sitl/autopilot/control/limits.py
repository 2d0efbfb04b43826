"""How fast, how steeply and with how much thrust the vehicle may be flown, phase by phase."""

import math
from typing import NamedTuple, Self

from sitl.autopilot.parameters import ParameterValues

RAMP_THRUST = 0.001  # the smallest thrust before flight: the ramp begins with none
TILT_MAX_DEG = 89.0


class Limits(NamedTuple):
    """What the position controller may request in this phase of flight."""

    speed_up_m_s: float
    speed_down_m_s: float
    tilt_tan: float  # tangent of the steepest tilt
    thrust_min: float


class LimitParameters(NamedTuple):
    """The limits of each phase."""

    flight: Limits  # MPC_Z_VEL_MAX_UP, MPC_Z_VEL_MAX_DN, MPC_TILTMAX_AIR, MPC_THR_MIN
    takeoff: Limits  # with MPC_TILTMAX_LND
    takeoff_speed_m_s: float  # MPC_TKO_SPEED, where nobody else says how fast to climb

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        up, down = values["MPC_Z_VEL_MAX_UP"], values["MPC_Z_VEL_MAX_DN"]
        return cls(
            flight=Limits(up, down, _tangent(values["MPC_TILTMAX_AIR"]), values["MPC_THR_MIN"]),
            takeoff=Limits(up, down, _tangent(values["MPC_TILTMAX_LND"]), RAMP_THRUST),
            takeoff_speed_m_s=values["MPC_TKO_SPEED"],
        )


def _tangent(tilt_deg: float) -> float:
    return math.tan(math.radians(min(tilt_deg, TILT_MAX_DEG)))
