"""What the MAVLink side needs of the vehicle: the face that the simulation shows it."""

from typing import Protocol

from sitl.records.course import CourseEvent, CourseStatus, Gate
from sitl.records.failures import FailureType
from sitl.records.missions import MissionItem, MissionProgress, MissionResult, Plan, PlanKind
from sitl.records.motion import VehicleState
from sitl.records.sensing import Estimate, Readings
from sitl.records.texts import StatusText
from sitl.records.vehicle import (
    AttitudeTarget,
    Command,
    CommandResult,
    OffboardSetpoint,
    SetpointEcho,
    Sticks,
    VehicleStatus,
)


class ParameterStore(Protocol):
    """A table of typed parameters under PX4's names."""

    def __contains__(self, name: object) -> bool: ...

    def names(self) -> list[str]:
        """All names in the order of their index."""

    def get(self, name: str) -> float:
        """Give the value: an int for INT32."""

    def type_of(self, name: str) -> int:
        """MAV_PARAM_TYPE: INT32 (6) or REAL32 (9)."""

    def set(self, name: str, value: float) -> None:
        """Change a value; raises UsageError if it is not allowed."""


class MissionStore(Protocol):
    """The plans that are kept, and how far the flight of one has come."""

    @property
    def progress(self) -> MissionProgress:
        """Where the mission stands."""

    def plan(self, kind: PlanKind) -> Plan:
        """Give a list, empty if there is none."""

    def check(self, kind: PlanKind, item: MissionItem) -> MissionResult:
        """Say whether an item can be flown or kept."""

    def replace(self, kind: PlanKind, plan: Plan, current: int) -> MissionResult:
        """Take a whole new list, or refuse it and keep the old one."""

    def set_current(self, sequence: int) -> bool:
        """Go to an item; False if there is no such item."""

    def drain_reached(self) -> list[int]:
        """Hand over the items that were reached since the last call."""


class CommandedAutopilot(Protocol):
    """Whoever flies the vehicle."""

    @property
    def missions(self) -> MissionStore:
        """Its missions, fences and rally points."""

    @property
    def status(self) -> VehicleStatus:
        """Modes, health and outputs now."""

    @property
    def setpoint_echo(self) -> SetpointEcho:
        """What the controllers follow now."""

    @property
    def yaw_rad(self) -> float:
        """Estimated heading."""

    def command(self, command: Command) -> CommandResult | None:
        """Carry out a command; None where PX4 stays silent."""

    def offboard_setpoint(self, setpoint: OffboardSetpoint) -> None:
        """Take the newest offboard setpoint."""

    def ground_station_heard(self) -> None:
        """Note a ground station's heartbeat."""

    def companion_heard(self) -> None:
        """Note a companion computer's heartbeat."""

    def attitude_setpoint(self, setpoint: AttitudeTarget) -> None:
        """Take the newest offboard setpoint that asks for an attitude or rates."""

    def manual_control(self, sticks: Sticks) -> None:
        """Take the sticks' positions."""

    def drain_texts(self) -> list[StatusText]:
        """Hand over what it has said since the last call."""


class JudgedVehicle(Protocol):
    """A vehicle on a course."""

    @property
    def course(self) -> CourseStatus:
        """The score so far."""

    @property
    def course_gates(self) -> tuple[Gate, ...]:
        """The gates of one lap, in order."""

    def drain_course_events(self) -> list[CourseEvent]:
        """Hand over what the referee saw since the last call."""


class SimulatedVehicle(JudgedVehicle, Protocol):
    """One simulated vehicle on its course."""

    @property
    def time_us(self) -> int:
        """Vehicle time since boot."""

    @property
    def state(self) -> VehicleState:
        """The truth."""

    @property
    def estimate(self) -> Estimate:
        """What the autopilot believes."""

    @property
    def readings(self) -> Readings:
        """What the sensors read."""

    @property
    def signal_fault(self) -> FailureType:
        """What a failure does to all that it sends and hears."""

    @property
    def is_silent(self) -> bool:
        """Whether a failure keeps it from sending and hearing anything."""

    @property
    def autopilot(self) -> CommandedAutopilot:
        """Whoever flies it."""

    @property
    def parameters(self) -> ParameterStore:
        """Its parameters."""
