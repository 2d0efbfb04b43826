"""The stages between arming and flying: rotors spin up, then the climb rate is ramped up.

DISARMED --armed--> SPOOL_UP --COM_SPOOLUP_TIME--> READY --wants to climb--> RAMP_UP
RAMP_UP --MPC_TKO_RAMP_T--> FLIGHT --landed--> READY;  any --disarmed--> DISARMED
"""

from enum import Enum
from typing import NamedTuple, Self

from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US
from sitl.frames import GRAVITY_M_S2


class TakeoffStage(Enum):
    """How far a take-off has come."""

    DISARMED = 0
    SPOOL_UP = 1
    READY = 2
    RAMP_UP = 3
    FLIGHT = 4


class TakeoffParameters(NamedTuple):
    """How long each stage takes."""

    spool_up_us: int  # COM_SPOOLUP_TIME
    ramp_us: int  # MPC_TKO_RAMP_T
    velocity_p: float  # of the vertical velocity loop, MPC_Z_VEL_P_ACC

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            spool_up_us=round(values["COM_SPOOLUP_TIME"] * SECOND_US),
            ramp_us=round(values["MPC_TKO_RAMP_T"] * SECOND_US),
            velocity_p=values["MPC_Z_VEL_P_ACC"],
        )


class TakeoffState(NamedTuple):
    """The stage, and the time when it began."""

    stage: TakeoffStage = TakeoffStage.DISARMED
    since_us: int = 0


class Takeoff:
    """Leads through the stages."""

    def __init__(self, parameters: TakeoffParameters) -> None:
        self.parameters = parameters
        self.state = TakeoffState()

    def start_airborne(self) -> None:
        """Begin in flight."""
        self.state = TakeoffState(TakeoffStage.FLIGHT, self.state.since_us)

    def update(self, time_us: int, *, armed: bool, landed: bool, wants_climb: bool) -> TakeoffStage:
        """Advance to `time_us`."""
        stage = before = self.state.stage
        if not armed:
            stage = TakeoffStage.DISARMED
        elif stage is TakeoffStage.FLIGHT:
            stage = TakeoffStage.READY if landed else stage
        elif stage is TakeoffStage.DISARMED:
            stage = TakeoffStage.SPOOL_UP
        elif stage is TakeoffStage.SPOOL_UP:
            is_over = time_us - self.state.since_us >= self.parameters.spool_up_us
            stage = TakeoffStage.READY if is_over else stage
        elif stage is TakeoffStage.READY:
            stage = TakeoffStage.RAMP_UP if wants_climb else stage
        elif time_us - self.state.since_us >= self.parameters.ramp_us:
            stage = TakeoffStage.FLIGHT
        if stage is not before:
            self.state = TakeoffState(stage, time_us)
        return stage

    def update_by_thrust(self, time_us: int, *, landed: bool, lifts: bool) -> TakeoffStage:
        """Advance where thrust is requested directly: there is nothing to ramp up."""
        stage = self.update(time_us, armed=True, landed=landed and not lifts, wants_climb=lifts)
        if stage is TakeoffStage.RAMP_UP:
            self.state = TakeoffState(TakeoffStage.FLIGHT, time_us)
        return self.state.stage

    def speed_limit(self, time_us: int, speed_up_m_s: float) -> float:
        """Ramp the climb limit from the descent rate at which the velocity loop gives no thrust."""
        (stage, since_us), parameters = self.state, self.parameters
        if stage is not TakeoffStage.RAMP_UP or parameters.ramp_us == 0:
            return speed_up_m_s
        start = -GRAVITY_M_S2 / parameters.velocity_p
        return start + (speed_up_m_s - start) * (time_us - since_us) / parameters.ramp_us
