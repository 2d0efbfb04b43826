"""Name what a mission may be in, ask for and end by, and the records that it works on."""

from dataclasses import dataclass
from enum import Enum

from flightstack.mavlink.telemetry import Telemetry


class Phase(Enum):
    """Where the mission stands."""

    WAITING = "waiting until the vehicle can be armed"
    ARMING = "arming"
    TAKING_OFF = "taking off"
    ENTERING_OFFBOARD = "entering offboard"
    FLYING = "flying"
    TAKEN_OVER = "taken over"
    LANDING = "landing"
    DONE = "done"


class Outcome(Enum):
    """How a flight ended."""

    COMPLETED = "completed"
    MISSED_GATE = "missed_gate"
    COLLISION = "collision"
    TIMEOUT = "timeout"
    TAKEN_OVER = "taken_over"
    COURSE_OVER = "course_over"  # before it began
    REFUSED = "refused"
    INTERRUPTED = "interrupted"
    CAMERA_LOST = "camera_lost"
    LINK_LOST = "link_lost"


class Request(Enum):
    """What the mission wants of the vehicle."""

    HOME_POSITION = "home position"
    ARM = "arm"
    DISARM = "disarm"
    TAKE_OFF = "take off"
    LAND = "land"
    HOLD_MODE = "hold mode"
    OFFBOARD_MODE = "offboard mode"


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What the mission knows of the world at one moment; times are vehicle time."""

    vehicle: Telemetry
    image_us: int  # stamp of the newest camera image
    stop_requested: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionState:
    """Where the mission stands, and since when (vehicle time)."""

    duration_us: int | None = None  # to fly in OFFBOARD at most
    gate_timeout_us: int | None = None  # to fly without passing a gate at most
    lands: bool = True  # at the end; False in a simulation that ends with the flight
    phase: Phase = Phase.WAITING
    entered_us: int | None = None
    requested_us: int | None = None  # the last request of this phase
    confirmed: bool = False  # the mode that this phase asked for has been seen
    slow_us: int | None = None  # since when it hovers after the climb
    offboard_us: int | None = None  # when FLYING began
    gates_passed: int = 0  # while FLYING
    gate_us: int | None = None  # when the last of them was seen
    ended_us: int | None = None  # when FLYING ended
    outcome: Outcome | None = None
