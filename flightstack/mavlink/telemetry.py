"""Keep the newest of what the vehicle, its camera and its referee say.

Any field may hold anything: a number that stands for nothing is unknown, one that is not finite is
not known, and what never ends is forgotten.
"""

import math
from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum

from pymavlink.dialects.v20 import common

from flightstack.clock import VehicleClock
from flightstack.mavlink.link import Message
from flightstack.mavlink.motion import MotionHistory
from flightstack.mavlink_numbers import CAMERA_COMPONENT, REFEREE_COMPONENT

Vector3 = tuple[float, float, float]
NO_TOTAL = 65535  # MISSION_CURRENT.total of a vehicle that has no mission
MAX_TEXT_CHARACTERS = 255 * 50  # as many chunks as chunk_seq can count
MAX_UNFINISHED = 16  # texts whose end has not come
MAX_TEXTS = 1000  # that nobody has asked for yet
CHUNK_CHARACTERS = 50  # a STATUSTEXT shorter than this ends its text


class LandedState(IntEnum):
    """Where the vehicle believes itself: MAV_LANDED_STATE."""

    UNKNOWN = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKING_OFF = 3
    LANDING = 4

    @classmethod
    def _missing_(cls, value: object) -> "LandedState":  # noqa: ARG003  (whatever it is)
        return cls.UNKNOWN


class CourseFailure(Enum):
    """How the referee ended the course early."""

    MISSED_GATE = "missed_gate"
    COLLISION = "collision"


FAILURES = {
    "Missed gate": CourseFailure.MISSED_GATE,
    "Collision with gate": CourseFailure.COLLISION,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Course:
    """What the referee has said so far."""

    gates_passed: int = 0
    gates_total: int | None = None
    finished: bool = False
    failed: bool = False
    failure: CourseFailure | None = None  # how it failed, once the referee has said that too

    @property
    def known(self) -> bool:
        """Whether there is a referee at all."""
        return self.gates_total is not None

    @property
    def over(self) -> bool:
        """Whether the referee has ended the course, either way."""
        return self.finished or self.failed


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusText:
    """A line for people, from the vehicle or its referee."""

    severity: int  # MAV_SEVERITY: 2 critical, 3 error, 4 warning, 6 info
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """One moment's view of the vehicle; times are vehicle time of reception."""

    heartbeat_us: int | None = None  # None until one has come whose time is known
    custom_mode: int = 0
    armed: bool = False
    armable: bool = False
    landed: LandedState = LandedState.UNKNOWN
    landed_us: int = 0  # since when `landed` holds
    home_altitude_amsl_m: float | None = None
    home_ned: Vector3 | None = None  # m
    position_ned: Vector3 | None = None  # m
    velocity_ned: Vector3 | None = None  # m/s
    target_ned: Vector3 | None = None  # m/s, the velocity that its controller follows
    target_yaw_rate: float | None = None  # rad/s
    target_us: int | None = None
    trigger_us: int | None = None  # stamp of the newest image that the camera has announced
    course: Course = field(default_factory=Course)


class TelemetryReceiver:
    """Fold messages into the newest view."""

    def __init__(self, clock: VehicleClock) -> None:
        self.latest = Telemetry()
        self.motion = MotionHistory()
        self.stream_uri: str | None = None
        self.stream_hz: float | None = None  # as its camera announces it
        self._clock = clock
        self._kind: tuple[int, int] | None = None  # MAV_TYPE and MAV_AUTOPILOT of the vehicle
        self._texts: list[StatusText] = []
        self._chunks: dict[tuple[int, int], str] = {}
        self._handlers = {
            common.MAVLINK_MSG_ID_ATTITUDE: self.motion.note_attitude,
            common.MAVLINK_MSG_ID_HEARTBEAT: self._heartbeat,
            common.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: self._extended_sys_state,
            common.MAVLINK_MSG_ID_HOME_POSITION: self._home_position,
            common.MAVLINK_MSG_ID_LOCAL_POSITION_NED: self._local_position,
            common.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: self._position_target,
            common.MAVLINK_MSG_ID_CAMERA_TRIGGER: self._camera_trigger,
            common.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION: self._video_stream_information,
            common.MAVLINK_MSG_ID_MISSION_CURRENT: self._mission_current,
            common.MAVLINK_MSG_ID_MISSION_ITEM_REACHED: self._mission_item_reached,
            common.MAVLINK_MSG_ID_STATUSTEXT: self._statustext,
        }

    def update(self, message: Message) -> None:
        """Take one message from the link; those of other kinds pass by."""
        handle = self._handlers.get(message.get_msgId())
        if handle is not None:
            handle(message)

    def lose_sight(self) -> None:
        """Forget the heartbeat of a vehicle that has fallen silent: the next one is news."""
        if self.latest.heartbeat_us is not None:
            self.latest = replace(self.latest, heartbeat_us=None)

    def begin_anew(self) -> None:
        """Forget all that a vehicle has said before it restarted, but for the course."""
        self.latest = Telemetry(course=self.latest.course)

    def forget(self) -> None:
        """Forget another vehicle altogether."""
        self.latest, self._kind = Telemetry(), None
        self.stream_uri = self.stream_hz = None
        self._texts.clear()
        self._chunks.clear()
        self.motion.forget()

    def drain_texts(self) -> list[StatusText]:
        """Return the whole texts since the last call."""
        texts, self._texts = self._texts, []
        return texts

    def _heartbeat(self, message: Message) -> None:
        if message.autopilot == common.MAV_AUTOPILOT_INVALID:  # no autopilot: it says nothing here
            return
        kind = (message.type, message.autopilot)
        if self._kind not in (None, kind):  # another than before: of no vehicle that we know
            return
        self._kind = kind
        self.latest = replace(
            self.latest,
            heartbeat_us=self._clock.stamp_us if self._clock.started else None,
            custom_mode=message.custom_mode,
            armed=bool(message.base_mode & common.MAV_MODE_FLAG_SAFETY_ARMED),
            armable=message.system_status == common.MAV_STATE_STANDBY,
        )

    def _extended_sys_state(self, message: Message) -> None:
        landed = LandedState(message.landed_state)
        if landed is not self.latest.landed:
            self.latest = replace(self.latest, landed=landed, landed_us=self._clock.stamp_us)

    def _home_position(self, message: Message) -> None:
        self.latest = replace(
            self.latest,
            home_altitude_amsl_m=message.altitude / 1000,
            home_ned=_known((message.x, message.y, message.z)),
        )

    def _local_position(self, message: Message) -> None:
        self.motion.note_position(message)
        self.latest = replace(
            self.latest,
            position_ned=_known((message.x, message.y, message.z)),
            velocity_ned=_known((message.vx, message.vy, message.vz)),
        )

    def _position_target(self, message: Message) -> None:
        self.latest = replace(
            self.latest,
            target_ned=(message.vx, message.vy, message.vz),
            target_yaw_rate=message.yaw_rate,
            target_us=self._clock.stamp_us,
        )

    def _camera_trigger(self, message: Message) -> None:
        self.latest = replace(self.latest, trigger_us=message.time_usec)

    def _video_stream_information(self, message: Message) -> None:
        if message.get_srcComponent() == CAMERA_COMPONENT:
            self.stream_uri = message.uri
            rate_hz = message.framerate
            self.stream_hz = rate_hz if math.isfinite(rate_hz) and rate_hz > 0.0 else None

    def _mission_current(self, message: Message) -> None:
        known = self.latest.course
        if message.total == NO_TOTAL or known.gates_total not in (None, message.total):
            return  # no course, or not the one that is flown
        course = replace(
            known,
            gates_passed=max(known.gates_passed, min(message.seq, message.total)),
            gates_total=message.total,
            finished=known.finished or message.mission_state == common.MISSION_STATE_COMPLETE,
            failed=known.failed or message.mission_state == common.MISSION_STATE_PAUSED,
        )
        self.latest = replace(self.latest, course=course)

    def _mission_item_reached(self, message: Message) -> None:
        known = self.latest.course
        most = message.seq + 1 if known.gates_total is None else known.gates_total
        passed = max(known.gates_passed, min(message.seq + 1, most))
        self.latest = replace(self.latest, course=replace(self.latest.course, gates_passed=passed))

    def _statustext(self, message: Message) -> None:
        key = (message.get_srcComponent(), message.id)
        begun = self._chunks.pop(key, "") if message.id and message.chunk_seq else ""
        text = begun + message.text
        is_whole = len(message.text) < CHUNK_CHARACTERS or len(text) >= MAX_TEXT_CHARACTERS
        if message.id and not is_whole:
            self._chunks[key] = text
            if len(self._chunks) > MAX_UNFINISHED:
                self._chunks.pop(next(iter(self._chunks)))
            return
        text = text.rstrip("\t")
        self._texts.append(StatusText(severity=message.severity, text=text))
        del self._texts[:-MAX_TEXTS]
        if key[0] == REFEREE_COMPONENT:
            self._judge(text)

    def _judge(self, text: str) -> None:
        for beginning, failure in FAILURES.items():
            if text.startswith(beginning):
                course = replace(self.latest.course, failed=True, failure=failure)
                self.latest = replace(self.latest, course=course)


def _known(vector: Vector3) -> Vector3 | None:
    """Return a vector that is one."""
    return vector if all(map(math.isfinite, vector)) else None
