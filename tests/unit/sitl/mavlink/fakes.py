"""A vehicle without physics, and a link without sockets."""

from dataclasses import dataclass, field
from typing import Any

from sitl.errors import UsageError
from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.rates import GROUND_STATION, StreamTable
from sitl.mavlink.wire.packets import Packed, split, wrap
from sitl.records.course import CourseEvent, CourseState, CourseStatus, Gate
from sitl.records.failures import FailureType
from sitl.records.missions import (
    MissionItem,
    MissionProgress,
    MissionResult,
    MissionState,
    Plan,
    PlanKind,
)
from sitl.records.modes import Mode
from sitl.records.motion import Vector3, VehicleState
from sitl.records.sensing import Estimate, GpsReading, Readings, SensorHealth
from sitl.records.texts import StatusText
from sitl.records.vehicle import (
    IDENTITY,
    NAN_VECTOR,
    AttitudeTarget,
    Command,
    CommandResult,
    OffboardSetpoint,
    SetpointEcho,
    Sticks,
    VehicleStatus,
)

HOME = (47.3977428, 8.5455967, 489.6)
ON_GROUND = 1
ZERO: Vector3 = (0.0, 0.0, 0.0)
LEVEL_FORCE: Vector3 = (0.0, 0.0, -9.80665)

STATUS = VehicleStatus(
    time_us=0,
    mode=Mode.HOLD,
    intended_mode=Mode.HOLD,
    custom_mode=Mode.HOLD.custom_mode,
    base_mode=29,
    system_status=3,
    armed=False,
    armable=True,
    failsafe=False,
    landed_state=ON_GROUND,
    home=HOME,
    home_ned=ZERO,
    home_valid=True,
    attitude_valid=True,
    position_valid=True,
    altitude_valid=True,
    throttle=0.0,
    actuator_outputs=(900, 900, 900, 900),
)
ECHO = SetpointEcho(
    time_us=0,
    position_ned=NAN_VECTOR,
    velocity_ned=NAN_VECTOR,
    acceleration_ned=(0.0, 0.0, 100.0),
    yaw_rad=0.0,
    yaw_rate_rad_s=0.0,
    q_ned_frd=IDENTITY,
    rates_frd=ZERO,
    thrust=0.001,
)


class FakeParameters:
    """Three parameters of both types."""

    def __init__(self) -> None:
        self.values: dict[str, float] = {
            "COM_DL_LOSS_T": 10,
            "MAV_SYS_ID": 1,
            "MPC_XY_VEL_MAX": 12.0,
        }

    def __contains__(self, name: object) -> bool:
        return name in self.values

    def names(self) -> list[str]:
        return list(self.values)

    def get(self, name: str) -> float:
        return self.values[name]

    def type_of(self, name: str) -> int:
        return 6 if isinstance(self.values[name], int) else 9

    def set(self, name: str, value: float) -> None:
        if not 0.0 <= value <= 100.0:
            raise UsageError(f"parameter {name}: must be 0 to 100")
        self.values[name] = value


class FakeMissions:
    """Keeps plans; takes what it is told to."""

    def __init__(self) -> None:
        self.plans: dict[PlanKind, Plan] = dict.fromkeys(PlanKind, ())
        self.progress = MissionProgress(0, 0, MissionState.NO_MISSION, in_mission_mode=False)
        self.reached: list[int] = []
        self.item_result = self.plan_result = MissionResult.ACCEPTED

    def plan(self, kind: PlanKind) -> Plan:
        return self.plans[kind]

    def check(self, _kind: PlanKind, _item: MissionItem) -> MissionResult:
        return self.item_result

    def replace(self, kind: PlanKind, plan: Plan, current: int) -> MissionResult:
        if self.plan_result is MissionResult.ACCEPTED:
            self.plans[kind] = plan
            if kind is PlanKind.MISSION:
                state = MissionState.NOT_STARTED if plan else MissionState.NO_MISSION
                self.progress = MissionProgress(current, len(plan), state, in_mission_mode=False)
        return self.plan_result

    def set_current(self, sequence: int) -> bool:
        known = sequence < self.progress.total
        if known:
            self.progress = self.progress._replace(sequence=sequence)
        return known

    def drain_reached(self) -> list[int]:
        reached, self.reached = self.reached, []
        return reached


@dataclass
class FakeAutopilot:
    """Remembers what it is told."""

    status: VehicleStatus = STATUS
    setpoint_echo: SetpointEcho = ECHO
    missions: FakeMissions = field(default_factory=FakeMissions)
    yaw_rad: float = 0.0
    result: int | None = 0
    commands: list[Command] = field(default_factory=list)
    setpoints: list[OffboardSetpoint] = field(default_factory=list)
    texts: list[StatusText] = field(default_factory=list)
    targets: list[AttitudeTarget] = field(default_factory=list)
    sticks: list[Sticks] = field(default_factory=list)
    heard: list[str] = field(default_factory=list)

    def command(self, command: Command) -> CommandResult | None:
        self.commands.append(command)
        return None if self.result is None else CommandResult(result=self.result)

    def offboard_setpoint(self, setpoint: OffboardSetpoint) -> None:
        self.setpoints.append(setpoint)

    def attitude_setpoint(self, setpoint: AttitudeTarget) -> None:
        self.targets.append(setpoint)

    def manual_control(self, sticks: Sticks) -> None:
        self.sticks.append(sticks)

    def ground_station_heard(self) -> None:
        self.heard.append("ground station")

    def companion_heard(self) -> None:
        self.heard.append("companion")

    def drain_texts(self) -> list[StatusText]:
        texts, self.texts = self.texts, []
        return texts

    def change(self, **changes: Any) -> None:
        self.status = self.status._replace(**changes)


class FakeVehicle:
    """Stands where it is put."""

    def __init__(self) -> None:
        self.time_us = 1_000_000
        self.is_silent = False
        self.signal_fault = FailureType.OK
        self.state = VehicleState(0, ZERO, ZERO, IDENTITY, ZERO, LEVEL_FORCE)
        self.estimate = Estimate(0, ZERO, ZERO, IDENTITY, ZERO, LEVEL_FORCE, *(True, True, True))
        self.readings = Readings(
            rates_frd=ZERO,
            specific_force_frd=LEVEL_FORCE,
            field_frd=(0.2, 0.0, 0.4),
            pressure_hpa=955.8,
            pressure_altitude_m=489.6,
            temperature_c=11.8,
            gps=GpsReading(0, ZERO, ZERO, fix_type=3, satellites=10),
            health=SensorHealth(),
        )
        self.autopilot = FakeAutopilot()
        self.parameters = FakeParameters()
        self.course = CourseStatus(gates_passed=0, gates_total=8, state=CourseState.ACTIVE)
        self.course_gates = tuple(
            Gate(index=n, centre_ned=(4.7 - n, 1.00004 * n, -3.0 - n), yaw_rad=0.25 * n)
            for n in range(8)
        )
        self.events: list[CourseEvent] = []

    def drain_course_events(self) -> list[CourseEvent]:
        events, self.events = self.events, []
        return events


class FakeOutlet:
    """Keeps what is sent, decoded again from its packets."""

    def __init__(self) -> None:
        self.messages: list[Any] = []
        self.packed: list[Packed] = []

    def send(self, message: Any) -> None:
        self.messages.append(message)

    def send_packed(self, packed: Packed) -> None:
        self.packed.append(packed)
        received = split(wrap(packed, sequence=0, system=1, component=1))
        self.messages.extend(item.message for item in received)

    def take(self) -> list[Any]:
        messages, self.messages = self.messages, []
        return messages


def make_request(outlet: FakeOutlet, system: int = 255, component: int = 190) -> Request:
    return Request(
        system=system,
        component=component,
        outlet=outlet,
        streams=StreamTable(GROUND_STATION),
    )
