"""A stand-in for PX4's side of the simulator interface alone, from recorded exchanges.

It says what a real PX4 1.17.0 said (`px4_hil_v1.17.0.hex`: its first two packets, answers on the
ground, at arming and in flight), and answers sensors with motor commands of their time.
"""

import socket
from typing import Any, Self

from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Received, pack, split, split_stream, wrap
from tests.paths import ROOT

RECORDED = [
    bytes.fromhex(line)
    for line in (ROOT / "tests" / "data" / "px4_hil_v1.17.0.hex").read_text().split()
]
OPENING = RECORDED[:2]  # COMMAND_LONG 511, HEARTBEAT
DISARMED, ARMED = 1, 129
SENSOR: int = mavlink.MAVLINK_MSG_ID_HIL_SENSOR
PATIENCE_S = 10.0


class Px4StandIn:
    """Connects, listens, answers; it flies nothing."""

    def __init__(self, port: int, *, opening: bool = True) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._unread = b""
        self._sequence = 0
        self._waiting: list[Received] = []
        self.sensors: list[Any] = []  # HIL_SENSOR, all so far
        self.others: list[Any] = []
        if opening:
            self.socket.sendall(b"".join(OPENING))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def await_sensors(self) -> Any:
        """Return the next HIL_SENSOR; raises TimeoutError where none comes."""
        while True:
            while self._waiting:
                message = self._waiting.pop(0).message
                if message.get_msgId() == SENSOR:
                    self.sensors.append(message)
                    return message
                self.others.append(message)
            data = self.socket.recv(4096)
            if not data:
                raise ConnectionResetError
            self._waiting, self._unread = split_stream(self._unread + data)

    def answer(self, time_us: int, thrust: float = 0.0, mode: int = DISARMED) -> None:
        """Send HIL_ACTUATOR_CONTROLS."""
        controls = [thrust] * 4 + [0.0] * 12
        message = mavlink.MAVLink_hil_actuator_controls_message(time_us, controls, mode, 1)
        self._sequence = (self._sequence + 1) & 0xFF
        raw = wrap(pack(message), sequence=self._sequence, system=1, component=1)
        self.socket.sendall(raw)

    def fly(self, ticks: int, thrust: float = 0.0, mode: int = DISARMED) -> None:
        """Answer so many sensors."""
        for _ in range(ticks):
            self.answer(self.await_sensors().time_usec, thrust, mode)

    @property
    def is_refused(self) -> bool:
        """Whether the simulator has closed the connection."""
        try:
            while self.socket.recv(4096):
                pass
        except TimeoutError:
            return False
        except ConnectionResetError:
            pass
        return True


def recorded(index: int) -> Any:
    """Return a recorded message."""
    return split(RECORDED[index])[0].message
