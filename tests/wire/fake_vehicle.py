"""A small vehicle in lockstep over real sockets: what the companion needs, and faults on demand."""

import contextlib
import select
import socket
import threading
import time
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from pymavlink.dialects.v20 import common

from flightstack.px4_modes import Px4Mode

IMAGE_US = 50_000
HOME_AMSL_M = 489.4
GATE_US = 500_000  # a gate is passed this often while flying forward
GATE_SPACING_M = 1.0
CLIMB_US = 1_000_000
DESCENT_US = 1_000_000
ANSWER_S = 5.0
FREE_RUN_S = 0.002  # wall time an image when nobody answers
SIGNING_EPOCH_S = 1_420_070_400  # 2015
FIVEFOLD_S = IMAGE_US / 5e6


@dataclass(kw_only=True)
class Script:
    """What goes wrong, and when (images in OFFBOARD)."""

    gates: int | None = 3  # None: no referee
    lists_gates: bool = True
    armable: bool = True
    ignored_commands: set[int] = field(default_factory=set)  # the first of each kind gets lost
    missed_gate: bool = False
    leave_offboard_after: int | None = None
    images_stop_after: int | None = None
    silent_after: int | None = None
    stream_breaks_after: int | None = None
    has_camera: bool = True  # without one, time runs free at five times real time
    autopilot: int = 12
    other_companion: bool = False  # whose heartbeat the vehicle forwards
    signing_key: bytes | None = None
    signing_lag_s: float = 0.0  # how far its signing clock is behind


class FakeVehicle:
    """Vehicle, camera and referee in one thread; enter it as a context."""

    def __init__(self, companion_port: int, script: Script | None = None) -> None:
        self.script = script or Script()
        self.received: list[Any] = []
        self.time_us = 0
        self.offboard_images = 0
        self.armed = False
        self.mode = Px4Mode.LOITER
        self.landed = common.MAV_LANDED_STATE_ON_GROUND
        self.takeoff_amsl_m: float | None = None
        self.flying = threading.Event()
        self.landing = threading.Event()
        self._mode_us = 0
        self._grounded_us = 0
        self._velocity = 0.0
        self._gates = 0
        self._answered_ms = -1
        self._stop = threading.Event()
        self._companion = ("127.0.0.1", companion_port)
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind(("127.0.0.1", 0))
        self._http = socket.create_server(("127.0.0.1", 0))
        self._client: socket.socket | None = None
        self._parser = common.MAVLink(None)
        self._parser.robust_parsing = True
        self._parser.signing = self._new_signing()
        self._sequences: dict[int, common.MAVLink] = {}
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "FakeVehicle":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(10)
        while select.select([self._udp], [], [], 0.0)[0]:  # a companion's last answer
            self._listen(0.0)
        for opened in (self._udp, self._http, self._client):
            if opened is not None:
                opened.close()

    def setpoints(self) -> list[Any]:
        kind = "SET_POSITION_TARGET_LOCAL_NED"
        return [message for message in self.received if message.get_type() == kind]

    def commands(self) -> list[int]:
        return [m.command for m in self.received if m.get_type() == "COMMAND_LONG"]

    def _run(self) -> None:
        while not self._stop.is_set() and self._client is None and self.script.has_camera:
            self._heartbeats()
            self._listen(0.02)
        while not self._stop.is_set():
            if self._reached(self.script.silent_after):
                self._listen(0.05)
                continue
            self._telemetry()
            if not self.script.has_camera:
                self._run_free(FIVEFOLD_S)
            elif self._reached(self.script.images_stop_after):
                self._run_free(FREE_RUN_S)
            else:
                self._image()
                self._await_answer()
            self.time_us += IMAGE_US
            self._move()

    def _reached(self, limit: int | None) -> bool:
        return limit is not None and self.offboard_images >= limit

    def _telemetry(self) -> None:
        ms = self.time_us // 1000
        self._send(common.MAVLink_attitude_message(ms, 0, 0, 0, 0, 0, 0))
        self._send(common.MAVLink_local_position_ned_message(ms, 0, 0, -3, self._velocity, 0, 0))
        if self.time_us % 500_000 == 0:
            self._heartbeats()
            self._send(common.MAVLink_extended_sys_state_message(0, self.landed))
            altitude_mm = round(HOME_AMSL_M * 1000)
            home = (0, 0, altitude_mm, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
            self._send(common.MAVLink_home_position_message(*home))
            self._course()
        if self.script.has_camera:
            self._send(common.MAVLink_camera_trigger_message(self.time_us, self._image_number), 100)

    @property
    def _image_number(self) -> int:
        return self.time_us // IMAGE_US

    def _heartbeats(self) -> None:
        base = 29 + (128 if self.armed else 0)
        status = 4 if self.armed else 3 if self.script.armable else 0
        self._send(
            common.MAVLink_heartbeat_message(2, self.script.autopilot, base, self.mode, status, 3)
        )
        self._send(common.MAVLink_heartbeat_message(30, 8, 0, 0, 4, 3), 100)

        if self.script.other_companion:
            self._send(common.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), 191)

    def _course(self) -> None:
        if self.script.gates is not None:
            state = 5 if self._gates >= self.script.gates else 3
            current = common.MAVLink_mission_current_message(self._gates, self.script.gates, state)
            self._send(current, 25)

    def _image(self) -> None:
        if self._client is None or self._reached(self.script.stream_breaks_after):
            self.script.stream_breaks_after = None
            self._accept(ANSWER_S if self._client is None else None)
        png = self._picture()
        head = (
            f"\r\n--frame\r\nContent-Type: image/png\r\nContent-Length: {len(png)}\r\n"
            f"X-Timestamp: {self.time_us / 1e6:.6f}\r\nX-Sequence: {self._image_number}\r\n\r\n"
        )
        with contextlib.suppress(OSError):
            if self._client is not None:
                self._client.sendall(head.encode() + png)

    def _picture(self) -> bytes:
        """Draw a bar that wanders over a picture of one colour."""
        image = np.full((64, 64, 3), (10, 20, 30), np.uint8)  # BGR
        image[8 + self._image_number % 56] = 255
        return cv2.imencode(".png", image)[1].tobytes()

    def _accept(self, timeout_s: float | None) -> None:
        if self._client is not None:
            self._client.close()
        self._http.settimeout(ANSWER_S if timeout_s is None else timeout_s)
        self._client, _ = self._http.accept()
        self._client.settimeout(ANSWER_S)
        self._client.recv(4096)
        self._client.sendall(
            b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=frame\r\n\r\n"
        )

    def _await_answer(self) -> None:
        deadline_s = time.monotonic() + ANSWER_S
        while self._answered_ms < self.time_us // 1000 and time.monotonic() < deadline_s:
            if self._stop.is_set():
                return
            self._listen(0.1)
        if self.mode == Px4Mode.OFFBOARD:
            self.offboard_images += 1

    def _run_free(self, period_s: float) -> None:
        ends_s = time.monotonic() + period_s
        while (left_s := ends_s - time.monotonic()) > 0:
            self._listen(left_s)

    def _listen(self, timeout_s: float) -> None:
        ready, _, _ = select.select([self._udp, self._http], [], [], timeout_s)
        if self._http in ready and self._client is None:
            self._accept(None)
        if self._udp in ready:
            for message in self._parser.parse_buffer(self._udp.recv(65535)) or []:
                self.received.append(message)
                self._handle(message)

    def _handle(self, message: Any) -> None:
        if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED":
            self._answered_ms = message.time_boot_ms
            self._velocity = message.vx
        elif message.get_type() == "COMMAND_LONG":
            if message.command in self.script.ignored_commands:
                self.script.ignored_commands.remove(message.command)
                return
            self._obey(message)
            self._send(
                common.MAVLink_command_ack_message(
                    message.command, 0, 0, 0, message.get_srcSystem(), message.get_srcComponent()
                ),
                message.target_component,
            )
        elif self.script.gates is not None and self.script.lists_gates:
            self._list_gates(message)

    def _list_gates(self, message: Any) -> None:
        to = (message.get_srcSystem(), message.get_srcComponent())
        if message.get_type() == "MISSION_REQUEST_LIST":
            self._send(common.MAVLink_mission_count_message(*to, self.script.gates or 0), 25)
        elif message.get_type() == "MISSION_REQUEST_INT":
            north = round(GATE_SPACING_M * 1e4) * (message.seq + 1)
            fields = (message.seq, 1, 16, 0, 1, 0.0, 0.7, 0.0, 0.0, north, 0, -3.0)
            self._send(common.MAVLink_mission_item_int_message(*to, *fields), 25)

    def _obey(self, message: Any) -> None:
        if message.command == common.MAV_CMD_COMPONENT_ARM_DISARM:
            self.armed = message.param1 == 1
        elif message.command == common.MAV_CMD_NAV_TAKEOFF:
            self.takeoff_amsl_m = message.param7
            self._enter(Px4Mode.TAKEOFF)
        elif message.command == common.MAV_CMD_NAV_LAND:
            self._enter(Px4Mode.LAND)
        elif message.command == common.MAV_CMD_DO_SET_MODE:
            self._enter(Px4Mode(int(message.param2) << 16 | int(message.param3) << 24))
        elif message.param1 == 269 and self.script.has_camera:
            uri = f"http://127.0.0.1:{self._http.getsockname()[1]}/stream"
            stream = (1, 1, 0, 1, 20.0, 64, 64, 0, 0, 90, b"camera", uri.encode())
            self._send(common.MAVLink_video_stream_information_message(*stream), 100)

    def _enter(self, mode: Px4Mode) -> None:
        if mode == Px4Mode.OFFBOARD:
            self.flying.set()
        if mode == Px4Mode.LAND:
            self.landing.set()
        self.mode, self._mode_us = mode, self.time_us

    def _move(self) -> None:
        in_mode_us = self.time_us - self._mode_us
        if self.armed and self.mode == Px4Mode.TAKEOFF and in_mode_us >= CLIMB_US:
            self.landed = common.MAV_LANDED_STATE_IN_AIR
            if in_mode_us >= 2 * CLIMB_US:
                self._enter(Px4Mode.LOITER)
        if self.armed and self.mode == Px4Mode.LAND and in_mode_us >= DESCENT_US:
            self.landed = common.MAV_LANDED_STATE_ON_GROUND
            self.armed = in_mode_us < 2 * DESCENT_US
        if self.mode == Px4Mode.OFFBOARD:
            self._judge(in_mode_us)
            if self._reached(self.script.leave_offboard_after):
                self._enter(Px4Mode.POSITION)

    def _judge(self, in_mode_us: int) -> None:
        if self.script.gates is None or self._velocity <= 0 or in_mode_us % GATE_US:
            return
        if self.script.missed_gate and self._gates == 1:
            self._send(common.MAVLink_statustext_message(4, b"Missed gate 1: 2.1 m right"), 25)
            return
        self._send(common.MAVLink_mission_item_reached_message(self._gates), 25)
        self._gates += 1
        self._course()

    def _send(self, message: Any, component: int = 1) -> None:
        source = self._sequences.get(component) or self._new_source(component)
        packet = message.pack(source)
        source.seq = (source.seq + 1) % 256
        with contextlib.suppress(OSError):
            self._udp.sendto(packet, self._companion)

    def _new_source(self, component: int) -> common.MAVLink:
        source = self._sequences[component] = common.MAVLink(None, 1, component)
        source.signing = self._parser.signing  # one clock, which what is heard sets forward
        return source

    def _new_signing(self) -> common.MAVLinkSigning:
        signing = common.MAVLinkSigning()
        signing.secret_key = self.script.signing_key
        signing.sign_outgoing = self.script.signing_key is not None
        signing.timestamp = int((time.time() - SIGNING_EPOCH_S - self.script.signing_lag_s) * 1e5)
        return signing
