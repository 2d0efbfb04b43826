"""A stretch of network between vehicle and companion that loses chosen setpoints."""

import select
import socket
import threading
from collections.abc import Callable
from typing import Any, Self

from pymavlink.dialects.v20 import common

DATAGRAM_BYTES = 65535


class DroppingProxy:
    """Forward datagrams both ways; `loses` is asked about each setpoint."""

    def __init__(self, companion_port: int, loses: Callable[[Any], bool]) -> None:
        self.lost = 0
        self._companion = ("127.0.0.1", companion_port)
        self._loses = loses
        self._to_vehicle = _socket()  # the vehicle speaks to this one
        self._to_companion = _socket()  # the companion answers to this one
        self._vehicle: tuple[str, int] | None = None
        self._stop = threading.Event()
        self._parser = common.MAVLink(None)
        self._parser.robust_parsing = True
        self._thread = threading.Thread(target=self._run, daemon=True)

    @property
    def vehicle_port(self) -> int:
        port: int = self._to_vehicle.getsockname()[1]
        return port

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(5)
        self._to_vehicle.close()
        self._to_companion.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            ready, _, _ = select.select([self._to_vehicle, self._to_companion], [], [], 0.1)
            if self._to_vehicle in ready:
                datagram, self._vehicle = self._to_vehicle.recvfrom(DATAGRAM_BYTES)
                self._to_companion.sendto(datagram, self._companion)
            if self._to_companion in ready:
                self._answer(self._to_companion.recv(DATAGRAM_BYTES))

    def _answer(self, datagram: bytes) -> None:
        for message in self._parser.parse_buffer(datagram) or []:
            if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED" and self._loses(message):
                self.lost += 1
                return
        if self._vehicle is not None:
            self._to_vehicle.sendto(datagram, self._vehicle)


def _socket() -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    opened.bind(("127.0.0.1", 0))
    return opened
