"""Tell flying from standing on the ground, by what the vehicle does and what is asked of it.

Standing is believed in three steps, each after a third of LNDMC_TRIG_TIME: ground contact (asked to
descend, yet little thrust and no motion), maybe landed (next to no thrust, not turning), landed.
Flying is believed at once.
"""

import math

from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.records.sensing import Estimate

LOW_THRUST = 0.3  # of the way from minimum to hover thrust; PX4's choice
MINIMUM_THRUST = 0.1  # likewise, for being landed


class LandDetector:
    """Keeps since when each step has been true."""

    def __init__(self, parameters: Parameters) -> None:
        self.ground_contact = True
        self.landed = True
        self._contact_since_us = self._maybe_since_us = self._landed_since_us = 0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take limits from the parameters."""
        p = parameters
        self._step_us = round(p["LNDMC_TRIG_TIME"] * SECOND_US / 3)
        self._climb_max = p["LNDMC_Z_VEL_MAX"]
        self._speed_max = p["LNDMC_XY_VEL_MAX"]
        self._turn_max = math.radians(p["LNDMC_ROT_MAX"])
        self._descent_min = 0.9 * p["MPC_LAND_CRWL"]
        room = p["MPC_THR_HOVER"] - p["MPC_THR_MIN"]
        self._low_thrust = p["MPC_THR_MIN"] + LOW_THRUST * room
        self._minimum_thrust = p["MPC_THR_MIN"] + MINIMUM_THRUST * room

    def start_airborne(self) -> None:
        """Begin in flight."""
        self.ground_contact = self.landed = False
        self._contact_since_us = self._maybe_since_us = self._landed_since_us = -1

    def update(self, estimate: Estimate, *, armed: bool, descending: bool, thrust: float) -> bool:
        """Advance by one tick and say whether the vehicle has landed; disarmed always counts.

        `descending` is whether a descent is asked for, `thrust` the collective that is given.
        """
        time_us = estimate.time_us
        if not armed:
            self.ground_contact = self.landed = True
            self._contact_since_us = self._maybe_since_us = self._landed_since_us = 0
            return True
        contact = self._is_contact(estimate, descending=descending, thrust=thrust)
        self._contact_since_us = _since(self._contact_since_us, time_us, true=contact)
        self.ground_contact = contact and time_us - self._contact_since_us >= self._step_us
        maybe = self.ground_contact and self._is_still(estimate) and thrust < self._minimum_thrust
        self._maybe_since_us = _since(self._maybe_since_us, time_us, true=maybe)
        settled = maybe and time_us - self._maybe_since_us >= self._step_us
        self._landed_since_us = _since(self._landed_since_us, time_us, true=settled)
        self.landed = settled and time_us - self._landed_since_us >= self._step_us
        return self.landed

    def _is_contact(self, estimate: Estimate, *, descending: bool, thrust: float) -> bool:
        # Once on the ground, only thrust or motion lift the vehicle off it again.
        vx, vy, vz = estimate.velocity_ned
        return (
            thrust < self._low_thrust
            and (descending or self.ground_contact)
            and abs(vz) < self._climb_max
            and (not estimate.position_valid or vx * vx + vy * vy < self._speed_max**2)
        )

    def _is_still(self, estimate: Estimate) -> bool:
        p, q, r = estimate.rates_frd
        return p * p + q * q + r * r < self._turn_max**2

    @property
    def descent_min_m_s(self) -> float:
        """The slowest descent that counts as one."""
        return self._descent_min


def _since(since_us: int, time_us: int, *, true: bool) -> int:
    """Keep the time since which a condition has been true; -1 while it is not."""
    if not true:
        return -1
    return time_us if since_us < 0 else since_us
