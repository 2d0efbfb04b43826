"""A vehicle as a real process on ports of its own, and clients at both of its links."""

import contextlib
import os
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Self

from pymavlink.dialects.v20 import development as mavlink

from tests.paths import ROOT

GCS, ONBOARD_CONTROLLER = 6, 18  # MAV_TYPE
PATIENCE_S = 10.0  # wall time
OTHER_SYSTEM, OTHER_COMPONENT = 42, 7
ATTITUDES = 2  # one may have been on its way before the texts of the same tick


class Client:
    """Somebody at the other end of a link, with pymavlink's codec and our own socket."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.1)
        self.port: int = self.socket.getsockname()[1]
        self.vehicle: tuple[str, int] | None = None
        self.codec = mavlink.MAVLink(None, srcSystem=OTHER_SYSTEM, srcComponent=OTHER_COMPONENT)
        self.codec.robust_parsing = True
        self._waiting: deque[Any] = deque()
        self._pings = 1000  # the vehicle's own count from 0

    def send(self, message: Any) -> None:
        """Send to wherever the vehicle was heard from."""
        assert self.vehicle is not None, "the vehicle was not heard yet"
        self.socket.sendto(message.pack(self.codec), self.vehicle)

    def say_hello(self, kind: int = GCS) -> None:
        """Send a HEARTBEAT."""
        self.send(mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 4, 3))

    def command(self, number: int, *params: float, target: tuple[int, int] = (1, 1)) -> None:
        """Send a COMMAND_LONG."""
        self.send(command_long(number, *params, target=target))

    def ask(self, message: Any) -> list[Any]:
        """Send a message; all that comes until a later ping is answered and a tick has passed."""
        self._pings += 1
        self.send(message)
        self.send(mavlink.MAVLink_ping_message(0, self._pings, 0, 0))
        heard: list[Any] = []
        left = ATTITUDES  # after the answer to the ping
        answered = False
        for received in self.messages():
            heard.append(received)
            answered |= received.get_type() == "PING" and received.seq == self._pings
            left -= answered and received.get_type() == "ATTITUDE"
            if not left:
                return heard
        raise AssertionError(f"no answer to the ping after {message}")

    def messages(self, timeout_s: float = PATIENCE_S) -> Iterator[Any]:
        """Give message after message until `timeout_s` of wall time is over."""
        deadline_s = time.monotonic() + timeout_s
        while True:
            while self._waiting:
                yield self._waiting.popleft()
            if time.monotonic() > deadline_s:
                return
            try:
                data, self.vehicle = self.socket.recvfrom(4096)
            except TimeoutError:
                continue
            self._waiting.extend(self.codec.parse_buffer(data) or [])

    def wait_for(
        self,
        condition: str | Callable[[Any], bool],
        what: str = "",
        timeout_s: float = PATIENCE_S,
    ) -> Any:
        """Return the first message of that name, or that meets the condition."""
        for message in self.messages(timeout_s):
            if isinstance(condition, str):
                if message.get_type() == condition:
                    return message
            elif condition(message):
                return message
        raise AssertionError(f"no {what or condition} within {timeout_s:g} s")

    def forget(self) -> None:
        """Drop what has come in so far."""
        for _ in self.messages(0.0):
            pass
        self._waiting.clear()

    def close(self) -> None:
        """Free the port."""
        self.socket.close()


class Vehicle:
    """The process and its two clients."""

    def __init__(
        self, *options: str, environment: dict[str, str] | None = None, module: str = "sitl"
    ) -> None:
        self.gcs, self.api = Client(), Client()
        self.started_s = time.monotonic()
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", module, f"--gcs-link=0:{self.gcs.port}"),
                *(f"--api-link=0:{self.api.port}", "--camera-port=0"),
                *("--ready-after=1", *options),  # the options go before that
            ],
            cwd=ROOT,
            env={"OMP_NUM_THREADS": "1"} | os.environ | (environment or {}),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(5.0)
        self.process.kill()
        self.process.communicate()
        self.gcs.close()
        self.api.close()

    def wait_until_up(self) -> None:
        """Wait until both links have spoken and the vehicle runs."""
        for client in (self.gcs, self.api):
            client.wait_for("ATTITUDE", timeout_s=3 * PATIENCE_S)

    def end(self, number: int) -> tuple[int, str]:
        """End it by a signal; its exit code and what it said."""
        self.process.send_signal(number)
        said, _ = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, said


def command_long(number: int, *params: float, target: tuple[int, int] = (1, 1)) -> Any:
    """Make a COMMAND_LONG; what is not given is 0."""
    values = [*params, *[0.0] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(*target, number, 0, *values)


def is_from(component: int, name: str) -> Callable[[Any], bool]:
    """Make a condition: a message of that name from that component of the vehicle."""

    def condition(message: Any) -> bool:
        return bool(message.get_type() == name and message.get_srcComponent() == component)

    return condition


def is_text(beginning: str) -> Callable[[Any], bool]:
    """Make a condition: a STATUSTEXT that begins so."""

    def condition(message: Any) -> bool:
        return bool(message.get_type() == "STATUSTEXT" and message.text.startswith(beginning))

    return condition


def is_acknowledgement(command: int) -> Callable[[Any], bool]:
    """Make a condition: a COMMAND_ACK of that command."""

    def condition(message: Any) -> bool:
        return bool(message.get_type() == "COMMAND_ACK" and message.command == command)

    return condition
