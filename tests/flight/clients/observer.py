"""Watch a vehicle from its ground-station link, by pymavlink alone, without waiting blindly."""

import socket
import subprocess
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Self

from pymavlink.dialects.v20 import common as mavlink

GROUND_STATION_PORT = 18570  # where PX4 hears ground stations, + instance
HEARTBEAT_S = 0.5
OFFBOARD = 0x00060000
TAKEOFF = 0x02040000
HOLD = 0x03040000
LAND = 0x06040000


class Observer:
    """A ground station; whoever speaks first is the link's partner, so it needs no fixed port."""

    def __init__(self, instance: int) -> None:
        self._vehicle = ("127.0.0.1", GROUND_STATION_PORT + instance)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(HEARTBEAT_S)
        self._codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self._codec.robust_parsing = True
        self._said_hello_s = 0.0
        self._waiting: deque[Any] = deque()  # came in one datagram with what was returned last

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, message: Any) -> None:
        self._socket.sendto(message.pack(self._codec), self._vehicle)

    def command(self, number: int, *parameters: float) -> None:
        filled = [*parameters, *[0.0] * (7 - len(parameters))]
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *filled))

    def wait_for(
        self,
        condition: Callable[[Any], bool],
        what: str,
        *,
        timeout_s: float,
        running: subprocess.Popen[bytes] | None = None,
    ) -> Any:
        """Return the first message that meets the condition; each message is looked at once."""
        deadline_s = time.monotonic() + timeout_s
        while time.monotonic() < deadline_s:
            self._waiting.extend(self._receive())
            while self._waiting:
                if condition(message := self._waiting.popleft()):
                    return message
            assert running is None or running.poll() is None, (
                f"{running.args!r} ended before {what}"
            )
        raise AssertionError(f"no {what} within {timeout_s:g} s")

    def wait_for_mode(self, custom_mode: int, *, armed: bool, timeout_s: float) -> Any:
        def in_mode(message: Any) -> bool:
            return (
                message.get_type() == "HEARTBEAT"
                and message.get_srcComponent() == 1
                and message.custom_mode == custom_mode
                and bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED) == armed
            )

        return self.wait_for(in_mode, f"mode 0x{custom_mode:08x}", timeout_s=timeout_s)

    def wait_for_text(self, start: str, *, timeout_s: float) -> Any:
        def says(message: Any) -> bool:
            return bool(message.get_type() == "STATUSTEXT" and message.text.startswith(start))

        return self.wait_for(says, f"text {start!r}", timeout_s=timeout_s)

    def wait_for_gate(
        self, gate: int, *, timeout_s: float, running: subprocess.Popen[bytes] | None = None
    ) -> Any:
        def passed(message: Any) -> bool:
            return bool(message.get_type() == "MISSION_ITEM_REACHED" and message.seq >= gate)

        return self.wait_for(passed, f"gate {gate}", timeout_s=timeout_s, running=running)

    def _receive(self) -> list[Any]:
        if time.monotonic() - self._said_hello_s > HEARTBEAT_S:
            self._said_hello_s = time.monotonic()
            self.send(
                mavlink.MAVLink_heartbeat_message(
                    mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3
                )
            )
        try:
            datagram = self._socket.recv(65535)
        except (TimeoutError, ConnectionRefusedError):  # refused: the vehicle is not up yet
            return []
        return self._codec.parse_buffer(datagram) or []
