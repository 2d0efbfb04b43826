"""Fly a vehicle process frame by frame: as fast as it can, and the same at any speed of the host.

In lockstep a frame comes each 50 ms of vehicle time and is answered by one setpoint, so a client
streams at exactly 20 Hz. A frame may also be answered by what PX4 refuses: the stream is then
silent, and time goes on.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Self

from pymavlink.dialects.v20 import development as mavlink

from tests.wire.stream_viewer import StreamViewer
from tests.wire.vehicle_process import Vehicle, is_acknowledgement, is_from

IMAGE_S = 0.05
BODY_NED, LOCAL_NED, UNSUPPORTED = 8, 1, 12  # MAV_FRAME
VELOCITY = 0x5C7  # velocity and yaw rate count
HELLO_IMAGES = 20
ARM, SET_MODE, OFFBOARD = 400, 176, 6.0
STANDBY, ACTIVE = 3, 4  # MAV_STATE
BEAT_S = 1.01  # between two of the autopilot's HEARTBEATs, at most
HOME_AMSL_M = 489.4
NEVER_S = 60.0


class Setpoint(NamedTuple):
    """What SET_POSITION_TARGET_LOCAL_NED says; m, m/s, rad, rad/s."""

    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_rate: float = 0.0
    frame: int = BODY_NED
    mask: int = VELOCITY
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0


STILL, SILENCE = Setpoint(), Setpoint(frame=UNSUPPORTED)


class Heard(NamedTuple):
    """A message and the vehicle time of the ATTITUDE (50 Hz) before it."""

    time_s: float
    message: Any


class LockstepPilot:
    """The ground station's end of a vehicle in lockstep, and its camera's viewer."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.gcs = vehicle.gcs
        self.time_s = 0.0
        self.says_hello = True  # once a second
        self._images = 0
        self.gcs.wait_for(is_from(100, "HEARTBEAT"))
        self.gcs.command(512, mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION, target=(1, 100))
        self._viewer = StreamViewer(self.gcs.wait_for("VIDEO_STREAM_INFORMATION").uri)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._viewer.__exit__(None, None, None)

    def fly(self, seconds: float, setpoint: Setpoint = STILL) -> list[Heard]:
        """Answer each frame of some vehicle time with the setpoint; what was heard."""
        heard: list[Heard] = []
        for _ in range(round(seconds / IMAGE_S)):
            heard += self.answer(setpoint)
        return heard

    def fly_until(
        self, is_there: Callable[[Any], bool], what: str, setpoint: Setpoint = STILL
    ) -> Heard:
        """Answer frames until a message comes."""
        begun_s = self.time_s
        while self.time_s < begun_s + NEVER_S:
            for heard in self.answer(setpoint):
                if is_there(heard.message):
                    return heard
        raise AssertionError(f"no {what} in {NEVER_S:g} s")

    def answer(self, setpoint: Setpoint) -> list[Heard]:
        """Take one frame and what came before it, and answer it."""
        part = self._viewer.read()
        heard = self._take(part.time_us) if self._images else []
        if self.says_hello and self._images % HELLO_IMAGES == 0:
            self.gcs.say_hello()
        self._images += 1
        s = setpoint
        numbers = (*s.position, *s.velocity, 0.0, 0.0, 0.0, s.yaw, s.yaw_rate)
        self.gcs.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                part.time_us // 1000, 1, 1, s.frame, s.mask, *numbers
            )
        )
        return heard

    def take_off_in_offboard(self, height_m: float) -> None:
        """Be in OFFBOARD, still, at about that height."""
        self.fly_until(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.system_status == STANDBY, "readiness"
        )
        self.enter_offboard()
        self.order(ARM, 1.0)
        self.fly_until(
            lambda m: m.get_type() == "LOCAL_POSITION_NED" and m.z < 0.5 - height_m,
            "height",
            Setpoint((0.0, 0.0, -2.0)),
        )
        self.fly(2.0)

    def enter_offboard(self) -> None:
        """Choose OFFBOARD and see it."""
        self.fly(0.2)
        self.gcs.command(SET_MODE, 1.0, OFFBOARD)
        self.fly_until(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.custom_mode == 0x00060000, "OFFBOARD"
        )

    def order(self, number: int, *params: float, setpoint: Setpoint = STILL) -> None:
        """Send a command that has to be accepted."""
        self.gcs.command(number, *params)
        answer = self.fly_until(is_acknowledgement(number), f"answer to {number}", setpoint)
        assert answer.message.result == 0

    def _take(self, until_us: int) -> list[Heard]:
        heard: list[Heard] = []
        for message in self.gcs.messages():
            if message.get_type() == "ATTITUDE":
                self.time_s = message.time_boot_ms / 1e3
            heard.append(Heard(self.time_s, message))
            if message.get_type() == "CAMERA_TRIGGER" and message.time_usec == until_us:
                return heard
        raise AssertionError(f"no trigger of the frame at {until_us} us")


def named(heard: list[Heard], name: str) -> list[Any]:
    """Give the autopilot's messages of that name."""
    return [h.message for h in heard if is_from(1, name)(h.message)]
