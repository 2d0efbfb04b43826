"""A stretch of network between vehicle and companion that does to datagrams what a test wants."""

import select
import socket
from collections.abc import Callable

from scripts.bench.between import Threaded

DATAGRAM_BYTES = 65535
Hook = Callable[[bytes], list[bytes]]  # what is delivered where one datagram was sent


def unchanged(datagram: bytes) -> list[bytes]:
    return [datagram]


class Proxy(Threaded):
    """Forward datagrams both ways on a thread of its own; enter it as a context."""

    def __init__(
        self, companion_port: int, *, to_vehicle: Hook = unchanged, to_companion: Hook = unchanged
    ) -> None:
        super().__init__()
        self._hooks = (to_vehicle, to_companion)
        self._companion = ("127.0.0.1", companion_port)
        self._vehicle: tuple[str, int] | None = None
        self._vehicle_side = open_socket()
        self._companion_side = open_socket()

    @property
    def vehicle_port(self) -> int:
        """Where the vehicle is to send."""
        port: int = self._vehicle_side.getsockname()[1]
        return port

    def _close(self) -> None:
        self._vehicle_side.close()
        self._companion_side.close()

    def _run(self) -> None:
        to_vehicle, to_companion = self._hooks
        while not self._stop.is_set():
            ready, _, _ = select.select([self._vehicle_side, self._companion_side], [], [], 0.1)
            if self._vehicle_side in ready:
                datagram, self._vehicle = self._vehicle_side.recvfrom(DATAGRAM_BYTES)
                for delivered in to_companion(datagram):
                    self._companion_side.sendto(delivered, self._companion)
            if self._companion_side in ready and self._vehicle is not None:
                for delivered in to_vehicle(self._companion_side.recv(DATAGRAM_BYTES)):
                    self._vehicle_side.sendto(delivered, self._vehicle)


def open_socket() -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    opened.bind(("127.0.0.1", 0))
    return opened
