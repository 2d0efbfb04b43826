"""The stages between arming and flying: rotors spin up, then the climb rate is ramped up.

DISARMED --armed--> SPOOL_UP --COM_SPOOLUP_TIME--> READY --wants to climb--> RAMP_UP
RAMP_UP --MPC_TKO_RAMP_T--> FLIGHT --landed--> READY;  any --disarmed--> DISARMED
"""

from enum import Enum

from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.frames import GRAVITY_M_S2


class Stage(Enum):
    """How far a take-off has come."""

    DISARMED = 0
    SPOOL_UP = 1
    READY = 2
    RAMP_UP = 3
    FLIGHT = 4


class Takeoff:
    """Keeps the stage and the time when it began."""

    def __init__(self, parameters: Parameters) -> None:
        self.stage = Stage.DISARMED
        self._since_us = 0
        self._time_us = 0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take times and gains from the parameters."""
        self._spool_up_us = round(parameters["COM_SPOOLUP_TIME"] * SECOND_US)
        self._ramp_us = round(parameters["MPC_TKO_RAMP_T"] * SECOND_US)
        self._z_velocity_p = parameters["MPC_Z_VEL_P_ACC"]

    def start_airborne(self) -> None:
        """Begin in flight."""
        self.stage = Stage.FLIGHT

    def update(self, time_us: int, *, armed: bool, landed: bool, wants_climb: bool) -> Stage:
        """Advance to `time_us`."""
        self._time_us = time_us
        stage = self.stage
        if not armed:
            stage = Stage.DISARMED
        elif stage is Stage.FLIGHT:
            stage = Stage.READY if landed else stage
        elif stage is Stage.DISARMED:
            stage = Stage.SPOOL_UP
        elif stage is Stage.SPOOL_UP:
            stage = Stage.READY if time_us - self._since_us >= self._spool_up_us else stage
        elif stage is Stage.READY:
            stage = Stage.RAMP_UP if wants_climb else stage
        elif time_us - self._since_us >= self._ramp_us:
            stage = Stage.FLIGHT
        if stage is not self.stage:
            self.stage, self._since_us = stage, time_us
        return stage

    def update_by_thrust(self, time_us: int, *, landed: bool, lifts: bool) -> Stage:
        """Advance where thrust is asked for directly: there is nothing to ramp up."""
        stage = self.update(time_us, armed=True, landed=landed and not lifts, wants_climb=lifts)
        if stage is Stage.RAMP_UP:
            self.stage, self._since_us = Stage.FLIGHT, time_us
        return self.stage

    def speed_limit(self, speed_up_m_s: float) -> float:
        """Ramp the climb limit from the descent rate at which the velocity loop gives no thrust."""
        if self.stage is not Stage.RAMP_UP or self._ramp_us == 0:
            return speed_up_m_s
        start = -GRAVITY_M_S2 / self._z_velocity_p
        return start + (speed_up_m_s - start) * (self._time_us - self._since_us) / self._ramp_us
