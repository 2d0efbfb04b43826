"""Read a camera's HTTP stream of multipart/x-mixed-replace parts.

Each part is one coded image with a Content-Length. X-Timestamp (seconds of vehicle time) and
X-Sequence say which image it is; a stream without them is stamped on arrival, and so is an image
whose stamp no vehicle can have. Opening has one deadline, however slowly the server answers.
"""

import contextlib
import http.client
import socket
import ssl
import threading
from collections.abc import Iterator
from urllib.parse import SplitResult, urlsplit

import numpy as np
from numpy.typing import NDArray

from flightstack.camera.mailbox import Arrival
from flightstack.camera.parts import decode_rgb, read_number, read_part, read_stamp_us
from flightstack.clock import VehicleClock
from flightstack.records import Image

OPEN_TIMEOUT_S = 5.0  # to connect and to answer, however slowly the headers come
MULTIPART = "multipart/x-mixed-replace"


class NotMultipartError(OSError):
    """The server answers, but with something that OpenCV should try."""


class MultipartSource:
    """One connection to a stream."""

    def __init__(self, uri: str, clock: VehicleClock, *, timeout_s: float = OPEN_TIMEOUT_S) -> None:
        """Open a stream; raises OSError, ValueError or HTTPException where there is none."""
        self._clock = clock
        self._count = 0
        parts = urlsplit(uri)
        host, path = parts.hostname or "", parts.path or "/"
        deadline_s = clock.wall_s() + timeout_s
        self._socket = _connect(parts, timeout_s)
        connection = http.client.HTTPConnection(host, parts.port)
        connection.sock = self._socket
        try:
            with _ended_after(deadline_s - clock.wall_s(), self._socket):
                if isinstance(self._socket, ssl.SSLSocket):
                    self._socket.do_handshake()
                connection.request("GET", path + (f"?{parts.query}" if parts.query else ""))
                self._response = connection.getresponse()
                self._check(uri)
        except (OSError, ValueError, http.client.HTTPException):
            self.close()
            raise
        self._socket.settimeout(None)  # a vehicle may stand still between two images

    def read(self) -> Arrival:
        """Wait for the next image that decodes; raises OSError when the stream has ended."""
        while True:
            headers, content = read_part(self._response)
            received_s = self._clock.wall_s()
            rgb = decode_rgb(content)
            if rgb is not None:
                return self._arrival(headers, rgb, received_s)

    def close(self) -> None:
        """End the stream; a `read` that waits in another thread raises OSError."""
        _shut(self._socket)
        self._socket.close()

    def _check(self, uri: str) -> None:
        content_type = self._response.getheader("Content-Type", "")
        if self._response.status == http.client.OK and content_type.startswith(MULTIPART):
            return
        if self._response.status != http.client.OK:
            raise OSError(0, f"{uri} answers {self._response.status} {self._response.reason}")
        raise NotMultipartError(0, f"{uri} is no {MULTIPART} stream but {content_type!r}")

    def _arrival(
        self, headers: dict[str, str], rgb: NDArray[np.uint8], received_s: float
    ) -> Arrival:
        self._count += 1
        told = headers.get("x-timestamp")
        stamp_us = None if told is None else read_stamp_us(told)
        image = Image(
            stamp_us=self._clock.now_us() if stamp_us is None else stamp_us,
            sequence=read_number(headers.get("x-sequence", ""), self._count),
            rgb=rgb,
        )
        odd = "" if told is None or stamp_us is not None else told
        return Arrival(image, received_s, stamped=stamp_us is not None, odd_stamp=odd)


def _connect(parts: SplitResult, timeout_s: float) -> socket.socket:
    """Connect to the host of an address; the handshake of https is still to come."""
    secure = parts.scheme == "https"
    port = parts.port or (http.client.HTTPS_PORT if secure else http.client.HTTP_PORT)
    connected = socket.create_connection((parts.hostname or "", port), timeout_s)
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if not secure:
        return connected
    context = ssl.create_default_context()
    return context.wrap_socket(
        connected, server_hostname=parts.hostname, do_handshake_on_connect=False
    )


@contextlib.contextmanager
def _ended_after(limit_s: float, opened: socket.socket) -> Iterator[None]:
    """End a connection, whatever it is doing, unless the block is left in time."""
    is_late = threading.Event()

    def end() -> None:
        is_late.set()
        _shut(opened)

    timer = threading.Timer(max(0.0, limit_s), end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
        if is_late.is_set():  # whatever the end of the connection looked like
            raise OSError(0, "the server answers too slowly")


def _shut(opened: socket.socket) -> None:
    with contextlib.suppress(OSError):
        opened.shutdown(socket.SHUT_RDWR)
