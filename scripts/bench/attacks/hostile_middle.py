"""Stand between a vehicle and its companion, as whoever wishes the companion ill."""

import contextlib
import random
import select
import socket
import struct
import threading
import zlib
from collections.abc import Callable, Iterator

from pymavlink.dialects.v20 import common

from scripts.bench.between import Threaded, told_modes
from scripts.fuzz.packets import packet

HOST = "127.0.0.1"
DATAGRAM_BYTES = 65535
KINDS = [kind for _, kind in sorted(common.mavlink_map.items())]
FLOATS = (b"\x00\x00\xc0\x7f", b"\x00\x00\x80\x7f", b"\x00\x00\x80\xff", b"\xff\xff\x7f\x7f")
COMPONENTS = (1, 1, 1, 25, 100)
IMAGE_END = b"\r\n--frame\r\n"
PNG_START = b"\x89PNG\r\n\x1a\n"
BREAK_EVERY = 20_000  # hostile parts between two broken connections
Maker = Callable[[], bytes]


def random_fields(rng: random.Random, system: int) -> bytes:
    """Make a packet in the vehicle's name, sound to the last bit, with anything in its fields."""
    kind = rng.choice(KINDS)
    size = kind.unpacker.size
    filling = rng.choice(
        (rng.randbytes(size), bytes(size), b"\xff" * size, rng.choice(FLOATS) * 64)
    )
    return packet(kind, filling[:size], (system, rng.choice(COMPONENTS)))


def undecodable(rng: random.Random) -> bytes:
    """Make the content of a part that is no picture, or one that nobody would want to decode."""
    way = rng.randrange(6)
    if way == 0:
        return rng.randbytes(rng.randrange(300))
    if way == 1:
        return b"P6 99999 99999 255\n" + rng.randbytes(50)
    if way == 2:
        return b"\xff\xd8\xff" + rng.randbytes(rng.randrange(200))
    size = rng.choice((1, 64, 20_000, 100_000, 2**31 - 1))
    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    chunks = _chunk(b"IHDR", header)
    if way == 3:
        return PNG_START + chunks + rng.randbytes(rng.randrange(100))
    data = _chunk(b"IDAT", zlib.compress(rng.randbytes(50)))
    length = rng.choice((0, 5, 2**31, 2**32 - 1))
    return PNG_START + chunks + (data if way == 4 else _chunk(b"tEXt", b"x", length))


def odd_part(rng: random.Random, content: bytes) -> bytes:
    """Wrap content in a part whose stamps may be anything."""
    stamps = ("-1", "1e20", "inf", "nan", "1733050000.5", "0.000001", f"{rng.random() * 1e4:.6f}")
    head = f"Content-Type: image/png\r\nContent-Length: {len(content)}\r\n"
    head += f"X-Timestamp: {rng.choice(stamps)}\r\nX-Sequence: {rng.randrange(2**40)}\r\n\r\n"
    return head.encode() + content + IMAGE_END


class Middle(Threaded):
    """Forward on a thread of its own, and put in what `make` makes; enter it as a context."""

    def __init__(self, make: Maker, each: float, count: int) -> None:
        super().__init__()
        self.sent = 0
        self.armed, self.mode = False, 0  # as the vehicle last said
        self.may_begin = threading.Event()
        self._make, self._each, self._count = make, each, count
        self._due = 0.0

    def _hostile(self) -> Iterator[bytes]:
        """Give as many as are due beside one thing that is forwarded."""
        if not self.may_begin.is_set():
            return
        self._due += self._each
        while self._due >= 1.0 and self.sent < self._count:
            self._due -= 1.0
            self.sent += 1
            yield self._make()


class LinkMiddle(Middle):
    """The vehicle's address, to the companion; `port` is where the vehicle is to send."""

    def __init__(self, companion_port: int, make: Maker, each: float, count: int) -> None:
        super().__init__(make, each, count)
        self._companion = (HOST, companion_port)
        self._vehicle: tuple[str, int] | None = None
        self._outer, self._inner = _udp(), _udp()
        self.port: int = self._outer.getsockname()[1]

    def _run(self) -> None:
        with self._outer, self._inner:
            while not self._stop.is_set():
                ready, _, _ = select.select([self._outer, self._inner], [], [], 0.1)
                if self._outer in ready:
                    data, self._vehicle = self._outer.recvfrom(DATAGRAM_BYTES)
                    self._note(data)
                    for each in (data, *self._hostile()):
                        self._inner.sendto(each, self._companion)
                if self._inner in ready and self._vehicle is not None:
                    with contextlib.suppress(OSError):
                        self._outer.sendto(self._inner.recv(DATAGRAM_BYTES), self._vehicle)

    def _note(self, data: bytes) -> None:
        for self.mode, self.armed in told_modes(data):
            continue


class CameraMiddle(Middle):
    """The camera's address: its stream, with other parts among its own."""

    def __init__(self, camera_port: int, make: Maker, each: float, count: int) -> None:
        super().__init__(make, each, count)
        self._camera = (HOST, camera_port)
        self._server = socket.create_server((HOST, 0))
        self._server.settimeout(0.1)
        self.uri = f"http://{HOST}:{self._server.getsockname()[1]}/stream"

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
        broken_at = self.sent + BREAK_EVERY
        waiting = b""
        while not self._stop.is_set() and self.sent < broken_at:
            try:
                data = camera.recv(DATAGRAM_BYTES)
            except TimeoutError:
                continue
            if not data:
                return
            *whole, waiting = (waiting + data).split(IMAGE_END)
            for part in whole:
                client.sendall(part + IMAGE_END)  # the first has the answer's own head
                client.sendall(b"".join(self._hostile()))


def _udp() -> socket.socket:
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    opened.bind((HOST, 0))
    opened.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    return opened


def _chunk(kind: bytes, data: bytes, length: int | None = None) -> bytes:
    size = struct.pack(">I", len(data) if length is None else length)
    return size + kind + data + struct.pack(">I", zlib.crc32(kind + data))
