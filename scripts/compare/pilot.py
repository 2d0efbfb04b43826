"""Fly a vehicle's process by a script: each camera image is answered by what the script says.

In lockstep a flight is a function of what is sent and of its order, so all that is sent in answer
to an image leaves in one datagram, the setpoint that lets time go on last.
"""

import socket
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from pymavlink.dialects.v20 import development as mavlink

from scripts.compare.messages import (
    ATTITUDE,
    CAMERA_TRIGGER,
    Message,
    Reader,
    ending_message,
    image_message,
    without_repeated_heartbeats,
)
from scripts.compare.processes import Link, started, vehicle_command
from scripts.compare.words import HOME_AMSL_M, NAN, Item, change_mode, command, packed

IMAGE_RATE_HZ = 20
HELLO_IMAGES = 20  # a heartbeat a second
STATION, COMPANION = (255, 190), (1, 191)  # system and component
GCS, API, SCRIPT = "gcs", "api", "script"
PATIENCE_S = 30.0  # wall time
BODY_NED, LOCAL_NED, UNSUPPORTED = 8, 1, 12  # MAV_FRAME
ONLY_VELOCITY = 0x5C7  # with yaw rate
SET_MESSAGE_INTERVAL, REQUEST_MESSAGE = 511, 512
ARM, TAKE_OFF, OFFBOARD = 400, 22, 6
REQUEST_ITEM, PLAN_ANSWER = (
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT,
    mavlink.MAVLINK_MSG_ID_MISSION_ACK,
)
READY_S, CLIMB_S = 1.5, 6.0
TRUTH_US = 4000  # how often the true state is told: each tick
BOUNDARY = b"--frame\r\n"

Setpoint = Callable[[int], Any]  # a message, given the stamp of the image that it answers in ms


def silence(stamp_ms: int) -> Any:
    """Answer an image by a setpoint that the vehicle refuses: for offboard there is none."""
    return local(frame=UNSUPPORTED)(stamp_ms)


def local(
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    yaw_rate: float = 0.0,
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    yaw: float = 0.0,
    *,
    frame: int = BODY_NED,
    mask: int = ONLY_VELOCITY,
) -> Setpoint:
    """Answer by a SET_POSITION_TARGET_LOCAL_NED; m, m/s, rad, rad/s."""
    numbers = (*position, *velocity, 0.0, 0.0, 0.0, yaw, yaw_rate)
    return lambda stamp_ms: mavlink.MAVLink_set_position_target_local_ned_message(
        stamp_ms, 1, 1, frame, mask, *numbers
    )


class Images:
    """The viewer of the camera stream."""

    def __init__(self, uri: str) -> None:
        address = urlsplit(uri)
        self._socket = socket.create_connection(
            (address.hostname or "", address.port or 80), timeout=PATIENCE_S
        )
        self._socket.sendall(f"GET {address.path} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        self._file = self._socket.makefile("rb")
        while self._file.readline() not in (BOUNDARY, b""):
            pass

    def read(self) -> tuple[int, Message]:
        """Wait for the next image; its stamp in us, and what is compared of it."""
        lines = iter(lambda: self._file.readline().decode().strip(), "")
        headers = dict(line.split(": ", 1) for line in lines)
        data = self._file.read(int(headers["Content-Length"]))
        self._file.readline()
        self._file.readline()
        stamp = headers["X-Timestamp"]
        return int(stamp.replace(".", "")), image_message(stamp, headers["X-Sequence"], data)

    def close(self) -> None:
        """Leave."""
        self._file.close()
        self._socket.close()


class Pilot:
    """Both links' other ends. What it may change between images: setpoint, sticks, greetings."""

    def __init__(self, gcs: Link, api: Link) -> None:
        self.setpoint: Setpoint = silence
        self.sticks: tuple[int, int, int, int] | None = None  # forward, right, up, turn
        self.greets = True  # a ground station's heartbeat, once a second
        self.time_s = 0.0  # vehicle time of the last image
        self.messages: list[Message] = []
        self._links = {GCS: gcs, API: api}
        self._reader = Reader()
        self._codecs: dict[tuple[int, int], Any] = {}
        self._outbox = b""
        self._images_seen = 0
        self._announced_us = {GCS: -1, API: -1}  # by the last CAMERA_TRIGGER
        self._wait(GCS, lambda m: m.source == "gcs 1/100")
        self.say(command(REQUEST_MESSAGE, 269, component=100))
        self._tell()
        uri = self._wait(GCS, lambda m: m.kind == 269).fields()["uri"]
        self._images = Images(uri)
        self.say(command(SET_MESSAGE_INTERVAL, 115, TRUTH_US))

    def say(self, *messages: Any, sender: tuple[int, int] = STATION) -> None:
        """Let messages leave with the next answer."""
        codec = self._codecs.setdefault(sender, mavlink.MAVLink(None, *sender))
        for message in messages:
            self._outbox += packed(message, codec)

    def ask(self, message: Any, *kinds: int) -> Message:
        """Send a message at once, while time stands, and wait for one of these types."""
        self.say(message)
        self._tell()
        return self._wait(GCS, lambda m: m.kind in kinds)

    def hear(self, is_last: Callable[[Message], bool]) -> Message:
        """Wait while time stands."""
        return self._wait(GCS, is_last)

    def fly(self, seconds: float, *messages: Any) -> None:
        """Answer the images of some vehicle time; the messages go with the first answer."""
        self.say(*messages)
        for _ in range(round(seconds * IMAGE_RATE_HZ)):
            self._answer(self._await_image())

    def wait_without_images(self, until_s: float) -> None:
        """Listen, sending nothing, to a vehicle whose camera has failed, until a vehicle time."""
        for link in (GCS, API):
            self._wait(link, lambda m: m.kind == ATTITUDE and _seconds(m) >= until_s)

    def finish(self, exit_code: int) -> list[Message]:
        """Give all that was said and heard."""
        self._images.close()
        said = without_repeated_heartbeats(self.messages)
        return [*said, ending_message("vehicle", exit_code, {})]

    def _await_image(self) -> int:
        stamp_us, image = self._images.read()
        for link in (GCS, API):
            if self._announced_us[link] < stamp_us:
                self._wait(link, lambda m: m.kind == CAMERA_TRIGGER and _stamp_us(m) == stamp_us)
        self.messages.append(image)
        return stamp_us

    def _answer(self, stamp_us: int) -> None:
        if self.greets and self._images_seen % HELLO_IMAGES == 0:
            self.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        if self.sticks is not None:
            forward, right, up, turn = self.sticks
            self.say(mavlink.MAVLink_manual_control_message(1, forward, right, up, turn, 0))
        self._images_seen += 1
        self.time_s = stamp_us / 1e6
        self.say(self.setpoint(stamp_us // 1000))
        self._tell()

    def _tell(self) -> None:
        data, self._outbox = self._outbox, b""
        self._links[GCS].send(data)
        self.messages += self._reader.read(data, SCRIPT)

    def _wait(self, link: str, is_last: Callable[[Message], bool]) -> Message:
        for message in self._hear(link):
            if is_last(message):
                return message
        raise ConnectionError(f"the vehicle fell silent on {link}")

    def _hear(self, link: str) -> Iterator[Message]:
        while True:
            for message in self._links[link].pending(self._reader, link):
                self.messages.append(message)
                if message.kind == CAMERA_TRIGGER:
                    self._announced_us[link] = _stamp_us(message)
                yield message
            if not self._links[link].receive(PATIENCE_S):
                return

    def take_off(self, height_m: float | None = None) -> None:
        """Be in hold at a height, by default the vehicle's own."""
        amsl_m = NAN if height_m is None else HOME_AMSL_M + height_m
        self.fly(READY_S)
        self.fly(0.1, command(ARM, 1.0))
        self.fly(CLIMB_S + (height_m or 0.0) / 2.0, command(TAKE_OFF, *[NAN] * 6, amsl_m))

    def enter_offboard(self, setpoint: Setpoint) -> None:
        """Stream setpoints, then be in offboard."""
        self.setpoint = setpoint
        self.fly(0.3)
        self.fly(0.1, change_mode(OFFBOARD))

    def upload(self, kind: int, *items: Item) -> None:
        """Upload a mission, a fence or rally points, while time stands."""
        count = mavlink.MAVLink_mission_count_message(1, 1, len(items), kind)
        answer = self.ask(count, REQUEST_ITEM, PLAN_ANSWER)
        while answer.kind == REQUEST_ITEM:
            sequence = answer.fields()["seq"]
            item = items[sequence].message(sequence, kind)
            answer = self.ask(item, REQUEST_ITEM, PLAN_ANSWER)


class ScriptedFlight(NamedTuple):
    """What a pilot does, with a vehicle of these parameters and options."""

    script: Callable[[Pilot], None]
    parameters: Mapping[str, float] = MappingProxyType({})
    options: tuple[str, ...] = ()

    def fly(self, root: Path) -> list[Message]:
        """Fly with the code at `root`; all that was said and heard."""
        with Link() as gcs, Link() as api:
            variables = {f"PX4_PARAM_{name}": str(v) for name, v in self.parameters.items()}
            command_line = vehicle_command(gcs.port, api.port, *self.options)
            with started(root, command_line, variables) as vehicle:
                pilot = Pilot(gcs, api)
                self.script(pilot)
                vehicle.terminate()
                return pilot.finish(vehicle.wait(PATIENCE_S))


def _stamp_us(trigger: Message) -> int:
    return int.from_bytes(trigger.payload[:8].ljust(8, b"\0"), "little")


def _seconds(attitude: Message) -> float:
    return int.from_bytes(attitude.payload[:4].ljust(4, b"\0"), "little") / 1e3
