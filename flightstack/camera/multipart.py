"""Read a camera's HTTP stream of multipart/x-mixed-replace parts.

Each part is one coded image with a Content-Length. X-Timestamp (seconds of vehicle time) and
X-Sequence say which image it is; a stream without them is stamped on arrival.
"""

import contextlib
import http.client
import socket
from urllib.parse import urlsplit

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.camera.mailbox import Arrival
from flightstack.clock import VehicleClock
from flightstack.records import Image

CONNECT_TIMEOUT_S = 5.0
MULTIPART = "multipart/x-mixed-replace"
MAX_PART_BYTES = 64 << 20
MAX_LINE_BYTES = 4096


class NotMultipartError(OSError):
    """The server answers, but with something that OpenCV should try."""


class MultipartSource:
    """One connection to a stream; `stamped` once its first image has carried a stamp."""

    def __init__(self, uri: str, clock: VehicleClock) -> None:
        self.stamped = False
        self._clock = clock
        self._count = 0
        parts = urlsplit(uri)
        kind = (
            http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        )
        connection = kind(parts.hostname or "", parts.port, timeout=CONNECT_TIMEOUT_S)
        path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        connection.request("GET", path)
        self._socket: socket.socket = connection.sock
        try:
            self._response = connection.getresponse()
            self._check(uri)
        except (OSError, http.client.HTTPException):
            self.close()
            raise
        self._socket.settimeout(None)  # a vehicle may stand still between two images

    def read(self) -> Arrival:
        """Wait for the next image that decodes; raises OSError when the stream has ended."""
        while True:
            headers = self._read_headers()
            content = self._read_exactly(int(headers.get("content-length", "-1")))
            received_s = self._clock.wall_s()
            rgb = decode_rgb(content)
            if rgb is not None:
                return Arrival(self._image(headers, rgb), received_s)

    def close(self) -> None:
        """End the stream; a `read` that waits in another thread raises OSError."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _check(self, uri: str) -> None:
        content_type = self._response.getheader("Content-Type", "")
        if self._response.status == http.client.OK and content_type.startswith(MULTIPART):
            return
        if self._response.status != http.client.OK:
            raise OSError(0, f"{uri} answers {self._response.status} {self._response.reason}")
        raise NotMultipartError(0, f"{uri} is no {MULTIPART} stream but {content_type!r}")

    def _image(self, headers: dict[str, str], rgb: NDArray[np.uint8]) -> Image:
        self._count += 1
        stamp = headers.get("x-timestamp")
        self.stamped = stamp is not None
        return Image(
            stamp_us=self._clock.now_us() if stamp is None else round(float(stamp) * 1e6),
            sequence=int(headers.get("x-sequence", self._count)),
            rgb=rgb,
        )

    def _read_headers(self) -> dict[str, str]:
        headers: dict[str, str] = {}
        while True:
            line = self._response.readline(MAX_LINE_BYTES)
            if not line:
                raise OSError(0, "the stream has ended")
            name, colon, value = line.decode("latin-1").partition(":")
            if colon:
                headers[name.strip().lower()] = value.strip()
            elif headers and not line.strip():
                return headers

    def _read_exactly(self, length: int) -> bytes:
        if not 0 <= length <= MAX_PART_BYTES:
            raise OSError(0, f"a part of {length} bytes: Content-Length is missing or wrong")
        content = self._response.read(length)
        if len(content) < length:
            raise OSError(0, "the stream has ended within a frame")
        return content


def decode_rgb(content: bytes) -> NDArray[np.uint8] | None:
    """Decode a PNG or JPEG into (H, W, 3) RGB; None where it is damaged."""
    if not content:
        return None
    bgr = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    return None if bgr is None else np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
