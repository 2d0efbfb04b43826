"""Stand between a vehicle's camera and whoever looks at it, and change what passes."""

import contextlib
import re
import socket
from collections.abc import Callable

import cv2
import numpy as np

from flightstack.arrays import Rgb
from scripts.bench.between import Threaded

HOST = "127.0.0.1"
CAMERA_PORT = 8090  # + instance
PART_END = b"\r\n--frame\r\n"
LENGTH = re.compile(rb"Content-Length: \d+")
STAMP = re.compile(rb"X-Timestamp: ([0-9.]+)\r\n")
NUMBER = re.compile(rb"X-Sequence: ([0-9]+)")
Change = Callable[[int, bytes], bytes | None]  # number and part: what is sent; None: hang up


class CameraProxy(Threaded):
    """Serves one client after the other; enter it as a context, then name the vehicle."""

    def __init__(self, change: Change) -> None:
        super().__init__()
        self.connections = 0
        self.vehicle_instance: int | None = None
        self._change = change
        self._parts = 0
        self._server = socket.create_server((HOST, 0))
        self._server.settimeout(0.1)
        self.uri = f"http://{HOST}:{self._server.getsockname()[1]}/stream"

    def _close(self) -> None:
        self._server.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            with contextlib.suppress(OSError):
                client, _ = self._server.accept()
                if self.vehicle_instance is None:
                    client.close()
                    continue
                address = (HOST, CAMERA_PORT + self.vehicle_instance)
                with client, socket.create_connection(address, 5.0) as camera:
                    self.connections += 1
                    self._forward(client, camera)

    def _forward(self, client: socket.socket, camera: socket.socket) -> None:
        client.settimeout(5.0)
        camera.settimeout(0.1)
        camera.sendall(client.recv(4096))
        waiting = b""
        while not self._stop.is_set():
            try:
                data = camera.recv(1 << 16)
            except TimeoutError:
                continue
            if not data:
                return
            *parts, waiting = (waiting + data).split(PART_END)
            for part in parts:
                self._parts += 1
                changed = self._change(self._parts, part)
                if changed is None:
                    return
                client.sendall(changed + PART_END)


def of_pictures(change: Callable[[Rgb], Rgb]) -> Change:
    """Make of each picture another, under the headers that it came with."""

    def changed(_number: int, part: bytes) -> bytes:
        head, gap, content = part.partition(b"\r\n\r\n")
        if not content:  # the head of the whole answer
            return part
        bgr = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        assert bgr is not None, "the vehicle's pictures decode"
        rgb = change(np.ascontiguousarray(bgr[..., ::-1], np.uint8))
        coded = cv2.imencode(".png", np.ascontiguousarray(rgb[..., ::-1]))[1].tobytes()
        return LENGTH.sub(b"Content-Length: %d" % len(coded), head) + gap + coded

    return changed


class Unstamped:
    """Takes the stamps off a stream, and keeps them for the test."""

    def __init__(self) -> None:
        self.true_us: dict[int, int] = {}  # by the image's number

    def __call__(self, _number: int, part: bytes) -> bytes:
        stamp, number = STAMP.search(part), NUMBER.search(part)
        if stamp is None or number is None:
            return part
        self.true_us[int(number[1])] = round(float(stamp[1]) * 1e6)
        return STAMP.sub(b"", part)
