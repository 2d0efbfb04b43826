"""Tell flying from standing on the ground, by what the vehicle does and what is requested of it.

Standing is believed in three steps, each after a third of LNDMC_TRIG_TIME: ground contact (told to
descend, yet little thrust and no motion), maybe landed (next to no thrust, not turning), landed.
Flying is believed at once.
"""

import math
from typing import NamedTuple, Self

from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US
from sitl.records.sensing import Estimate

LOW_THRUST = 0.3  # of the way from minimum to hover thrust; PX4's choice
MINIMUM_THRUST = 0.1  # likewise, for being landed


class LandDetectorParameters(NamedTuple):
    """What counts as little thrust and as no motion, and for how long."""

    step_us: int  # a third of LNDMC_TRIG_TIME
    climb_max_m_s: float  # up or down, LNDMC_Z_VEL_MAX
    speed_max_m_s: float  # LNDMC_XY_VEL_MAX
    turn_max_rad_s: float  # LNDMC_ROT_MAX
    descent_min_m_s: float  # the slowest descent that counts as one, from MPC_LAND_CRWL
    low_thrust: float  # from MPC_THR_MIN and MPC_THR_HOVER
    minimum_thrust: float  # likewise

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        thrust_min = values["MPC_THR_MIN"]
        room = values["MPC_THR_HOVER"] - thrust_min
        return cls(
            step_us=round(values["LNDMC_TRIG_TIME"] * SECOND_US / 3),
            climb_max_m_s=values["LNDMC_Z_VEL_MAX"],
            speed_max_m_s=values["LNDMC_XY_VEL_MAX"],
            turn_max_rad_s=math.radians(values["LNDMC_ROT_MAX"]),
            descent_min_m_s=0.9 * values["MPC_LAND_CRWL"],
            low_thrust=thrust_min + LOW_THRUST * room,
            minimum_thrust=thrust_min + MINIMUM_THRUST * room,
        )


class LandState(NamedTuple):
    """What is believed, and since when each step has been true; -1 while it is not."""

    ground_contact: bool
    landed: bool
    contact_since_us: int
    maybe_since_us: int
    landed_since_us: int


ON_GROUND = LandState(
    ground_contact=True, landed=True, contact_since_us=0, maybe_since_us=0, landed_since_us=0
)
IN_AIR = LandState(
    ground_contact=False, landed=False, contact_since_us=-1, maybe_since_us=-1, landed_since_us=-1
)


class LandDetector:
    """Keeps what is believed."""

    def __init__(self, parameters: LandDetectorParameters) -> None:
        self.parameters = parameters
        self.state = ON_GROUND

    def start_airborne(self) -> None:
        """Begin in flight."""
        self.state = IN_AIR

    def update(self, estimate: Estimate, *, armed: bool, descending: bool, thrust: float) -> bool:
        """Advance by one tick and say whether the vehicle has landed; disarmed always counts.

        `descending` is whether a descent is requested, `thrust` the collective that is given.
        """
        if not armed:
            self.state = ON_GROUND
        elif not self._is_contact(estimate, descending=descending, thrust=thrust):
            self.state = IN_AIR
        else:
            self.state = self._settle(estimate, thrust)
        return self.state.landed

    def _settle(self, estimate: Estimate, thrust: float) -> LandState:
        """Take the steps that are due while the vehicle is in contact with the ground."""
        before, time_us, step_us = self.state, estimate.time_us, self.parameters.step_us
        contact_since_us = _since(before.contact_since_us, time_us, true=True)
        ground_contact = time_us - contact_since_us >= step_us
        still = thrust < self.parameters.minimum_thrust and self._is_still(estimate)
        maybe = ground_contact and still
        maybe_since_us = _since(before.maybe_since_us, time_us, true=maybe)
        settled = maybe and time_us - maybe_since_us >= step_us
        landed_since_us = _since(before.landed_since_us, time_us, true=settled)
        landed = settled and time_us - landed_since_us >= step_us
        return LandState(ground_contact, landed, contact_since_us, maybe_since_us, landed_since_us)

    def _is_contact(self, estimate: Estimate, *, descending: bool, thrust: float) -> bool:
        # Once on the ground, only thrust or motion lift the vehicle off it again.
        parameters, (vx, vy, vz) = self.parameters, estimate.velocity_ned
        return (
            thrust < parameters.low_thrust
            and (descending or self.state.ground_contact)
            and abs(vz) < parameters.climb_max_m_s
            and (not estimate.position_valid or vx * vx + vy * vy < parameters.speed_max_m_s**2)
        )

    def _is_still(self, estimate: Estimate) -> bool:
        p, q, r = estimate.rates_frd
        return p * p + q * q + r * r < self.parameters.turn_max_rad_s**2


def _since(since_us: int, time_us: int, *, true: bool) -> int:
    """Keep the time since which a condition has been true; -1 while it is not."""
    if not true:
        return -1
    return time_us if since_us < 0 else since_us
