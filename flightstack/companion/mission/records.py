"""Name what a mission may be in, ask for and end by, and the records that it works on."""

from dataclasses import dataclass
from enum import Enum

from flightstack.mavlink.telemetry import Telemetry


class MissionPhase(Enum):
    """Where the mission stands."""

    WAITING = "waiting until the vehicle can be armed"
    ARMING = "arming"
    TAKING_OFF = "taking off"
    ENTERING_OFFBOARD = "entering offboard"
    FLYING = "flying"
    TAKEN_OVER = "taken over"
    REACHING = "trying to reach the vehicle"
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
    RESTARTED = "vehicle_restarted"
    FOUND_ARMED = "found_armed"  # before it began: armed by somebody else, or by a flight before
    OTHER_PILOT = "other_pilot"  # somebody else steers the same vehicle
    PART_FAILED = "part_failed"  # of the pilot: perception, policy or strategy
    OUT_OF_LIMITS = "out_of_limits"  # of height, distance or speed
    COMPANION_FAILED = "companion_failed"  # an error of our own


class MissionRequest(Enum):
    """What the mission wants of the vehicle."""

    HOME_POSITION = "home position"
    ARM = "arm"
    DISARM = "disarm"
    TAKE_OFF = "take off"
    LAND = "land"
    HOLD_MODE = "hold mode"
    OFFBOARD_MODE = "offboard mode"


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """The vehicle stands still in the air, and is landed if that lasts; times are vehicle time."""

    reason: Outcome  # why it holds, and what the flight ends by if it lasts
    since_us: int
    lands_after_us: int

    @property
    def lands_us(self) -> int:
        """When it lands."""
        return self.since_us + self.lands_after_us


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """What the mission knows of the world at one moment; times are vehicle time."""

    vehicle: Telemetry
    image_us: int  # stamp of the newest camera image
    holds: tuple[Hold, ...] = ()  # raised by anybody but the camera
    camera_lies_us: int | None = None  # since when what it shows or says cannot be
    stop_requested: bool = False
    vehicle_silent: bool = False  # for so long that it is lost
    vehicle_gone: bool = False  # its end of the link has closed for good
    restarted_us: int | None = None  # it has since the last look; its last time before
    other_pilot: bool = False  # steers the vehicle, or is about to


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionStatus:
    """Where the mission stands, and since when (vehicle time)."""

    duration_us: int | None = None  # to fly in OFFBOARD at most
    gate_timeout_us: int | None = None  # to fly without passing a gate at most
    lands: bool = True  # at the end; False in a simulation that ends with the flight
    takes_over: bool = False  # goes on with a vehicle that was armed before, or has a pilot
    reach_us: int = 300_000_000  # for so long a silent vehicle that we have lifted is called
    phase: MissionPhase = MissionPhase.WAITING
    entered_us: int | None = None
    requested_us: int | None = None  # the last request of this phase
    confirmed: bool = False  # the mode that this phase asked for has been seen
    slow_us: int | None = None  # since when it hovers after the climb
    hold: Hold | None = None  # while it lasts, the vehicle is sent a velocity of zero
    offboard_us: int | None = None  # when FLYING began
    gates_passed: int = 0  # while FLYING
    gate_us: int | None = None  # when the last of them was seen
    ended_us: int | None = None  # when FLYING ended
    outcome: Outcome | None = None
