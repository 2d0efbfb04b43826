"""Stand between a vehicle and its companion and do to what passes what radios and cameras do."""

import contextlib
import heapq
import itertools
import random
import re
import select
import socket
import time
from dataclasses import dataclass

from scripts.bench.between import Threaded, told_modes

HOST = "127.0.0.1"
DATAGRAM_BYTES = 65535
IMAGE_END = b"\r\n--frame\r\n"
HEAD_END = b"\r\n\r\n"
LENGTH = re.compile(rb"Content-Length: \d+")
OFFBOARD, TAKEOFF, LAND = 0x00060000, 0x02040000, 0x06040000


@dataclass(slots=True)
class Weather:
    """What becomes of a datagram, either way."""

    loss: float = 0.0  # share
    delay_s: float = 0.0
    jitter_s: float = 0.0  # more than the time between two datagrams: they change order
    copies: float = 0.0  # share that comes twice
    out_until_s: float = 0.0  # nothing passes before this time (monotonic)


class LinkRelay(Threaded):
    """Forwards datagrams under a weather; notes what the vehicle says of itself."""

    def __init__(self, companion_port: int, seed: int = 0) -> None:
        self.weather = Weather()
        self.armed, self.mode, self.was_armed = False, 0, False
        self.heard_s = time.monotonic()
        self._rng = random.Random(seed)  # noqa: S311  (chance that can be repeated)
        self._companion = (HOST, companion_port)
        self._vehicle: tuple[str, int] | None = None
        self._outer, self._inner = _udp(), _udp()
        self.port: int = self._outer.getsockname()[1]
        self._due: list[tuple[float, int, bool, bytes]] = []
        self._numbers = itertools.count()
        super().__init__()

    @property
    def phase(self) -> str:
        """Which phase the vehicle is in, by its own words."""
        if not self.armed:
            return "after" if self.was_armed else "before arming"
        return {TAKEOFF: "take-off", OFFBOARD: "flying", LAND: "landing"}.get(self.mode, "between")

    def _run(self) -> None:
        with self._outer, self._inner:
            while not self._stop.is_set():
                wait_s = 0.1 if not self._due else self._due[0][0] - time.monotonic()
                ready, _, _ = select.select([self._outer, self._inner], [], [], max(0.0, wait_s))
                if self._outer in ready:
                    with contextlib.suppress(OSError):
                        data, self._vehicle = self._outer.recvfrom(DATAGRAM_BYTES)
                        self._note(data)
                        self._take(data, down=True)
                if self._inner in ready:
                    with contextlib.suppress(OSError):
                        self._take(self._inner.recv(DATAGRAM_BYTES), down=False)
                self._deliver()

    def _take(self, data: bytes, *, down: bool) -> None:
        weather, now_s = self.weather, time.monotonic()
        if now_s < weather.out_until_s or self._rng.random() < weather.loss:
            return
        for _ in range(2 if self._rng.random() < weather.copies else 1):
            due_s = now_s + weather.delay_s + self._rng.random() * weather.jitter_s
            heapq.heappush(self._due, (due_s, next(self._numbers), down, data))

    def _deliver(self) -> None:
        while self._due and self._due[0][0] <= time.monotonic():
            _, _, down, data = heapq.heappop(self._due)
            with contextlib.suppress(OSError):
                if down:
                    self._inner.sendto(data, self._companion)
                elif self._vehicle is not None:
                    self._outer.sendto(data, self._vehicle)

    def _note(self, data: bytes) -> None:
        for self.mode, self.armed in told_modes(data):
            self.heard_s = time.monotonic()
            self.was_armed |= self.armed


class CameraRelay(Threaded):
    """Forwards a camera's stream, until `fault` says otherwise."""

    def __init__(self, camera_port: int) -> None:
        self.fault = ""  # or "stalls", "breaks", "is gone", "freezes"
        self._camera = (HOST, camera_port)
        self._server = socket.create_server((HOST, 0))
        self._server.settimeout(0.1)
        self.uri = f"http://{HOST}:{self._server.getsockname()[1]}/stream"
        super().__init__()

    def _run(self) -> None:
        with self._server:
            while not self._stop.is_set():
                with contextlib.suppress(OSError):
                    client, _ = self._server.accept()
                    with client, socket.create_connection(self._camera, 5.0) as camera:
                        self._forward(client, camera)

    def _forward(self, client: socket.socket, camera: socket.socket) -> None:
        client.settimeout(5.0)
        camera.settimeout(0.1)
        camera.sendall(client.recv(DATAGRAM_BYTES))
        waiting, frozen = b"", b""
        while not self._stop.is_set() and not self._breaks() and not _has_left(client):
            try:
                data = camera.recv(DATAGRAM_BYTES)
            except TimeoutError:
                continue
            if not data:
                return
            *whole, waiting = (waiting + data).split(IMAGE_END)
            for part in whole:
                head, _, content = part.partition(HEAD_END)
                frozen = content if self.fault != "freezes" or not frozen else frozen
                if self.fault == "freezes":
                    length = b"Content-Length: %d" % len(frozen)
                    part = LENGTH.sub(length, head) + HEAD_END + frozen  # noqa: PLW2901
                if self.fault != "stalls":
                    client.sendall(part + IMAGE_END)

    def _breaks(self) -> bool:
        if self.fault == "breaks":
            self.fault = ""
            return True
        return self.fault == "is gone"


def _has_left(client: socket.socket) -> bool:
    """Whether a client that has nothing more to say has closed its end, or died."""
    return bool(select.select([client], [], [], 0.0)[0])


def _udp() -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.bind((HOST, 0))
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    return opened
