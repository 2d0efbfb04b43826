"""The bytes of the camera stream: HTTP requests in, multipart images out. No sockets here."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from sitl.records.images import Image

BOUNDARY = b"frame"
MAX_REQUEST_BYTES = 8192
# Stored, not deflated: 14 us to code and 13 us to decode instead of 260 and 100, for 12 kB.
PNG_OPTIONS = (
    cv2.IMWRITE_PNG_COMPRESSION,
    0,
    cv2.IMWRITE_PNG_FILTER,
    cv2.IMWRITE_PNG_FILTER_NONE,
)
JPEG_OPTIONS = (cv2.IMWRITE_JPEG_QUALITY, 90)
PAGE = b"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>flightstack sitl camera</title>
<style>body{margin:0;background:#111}img{width:100vmin;display:block;margin:auto;
image-rendering:pixelated}</style></head>
<body><img src="/stream.mjpg" alt="front camera"></body></html>
"""


@dataclass(frozen=True, slots=True)
class Coding:
    """How the images of a stream are coded."""

    suffix: str
    content_type: bytes
    options: tuple[int, ...]

    def encode(self, rgb: NDArray[np.uint8]) -> bytes:
        """Code an RGB image."""
        bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
        _, data = cv2.imencode(self.suffix, bgr, self.options)
        return bytes(data)


PNG = Coding(".png", b"image/png", PNG_OPTIONS)  # lossless: what a companion takes
JPEG = Coding(".jpg", b"image/jpeg", JPEG_OPTIONS)  # what OpenCV and ffmpeg open
STREAMS: Mapping[str, Coding] = {"/stream": PNG, "/stream.mjpg": JPEG}
WATCH = b"watch"  # GET /stream?watch
STREAM_HEAD = (
    b"HTTP/1.1 200 OK\r\nConnection: close\r\nCache-Control: no-store\r\n"
    b"Content-Type: multipart/x-mixed-replace; boundary=" + BOUNDARY + b"\r\n\r\n"
    b"--" + BOUNDARY + b"\r\n"
)


def is_complete(request: bytes) -> bool:
    """Whether a request's head has come in whole."""
    return b"\r\n\r\n" in request or b"\n\n" in request


def answer(request: bytes) -> tuple[bytes, Coding | None]:
    """Answer a request's head; with a coding, images follow, without, the answer is all."""
    method, _, rest = request.split(b"\n", 1)[0].strip().partition(b" ")
    path = rest.split(b" ", 1)[0].split(b"?", 1)[0].decode("latin-1")
    if method != b"GET":
        return _page(b"405 Method Not Allowed", b"only GET is understood here\n"), None
    if path in STREAMS:
        return STREAM_HEAD, STREAMS[path]
    if path == "/":
        return _page(b"200 OK", PAGE, b"text/html; charset=utf-8"), None
    return _page(b"404 Not Found", b"there are /, /stream and /stream.mjpg\n"), None


def only_watches(request: bytes) -> bool:
    """Whether whoever asks only looks: lockstep does not wait for an answer."""
    target = request.split(b"\n", 1)[0].split(b" ")[1:2]
    return b"".join(target).partition(b"?")[2] == WATCH


def part(image: Image, coding: Coding) -> bytes:
    """Wrap one image; the boundary follows it, so that browsers show it at once."""
    data = coding.encode(image.rgb)
    seconds, microseconds = divmod(image.time_us, 1_000_000)
    head = (
        f"Content-Length: {len(data)}\r\n"
        f"X-Timestamp: {seconds}.{microseconds:06d}\r\n"
        f"X-Sequence: {image.sequence}\r\n\r\n"
    )
    return b"".join(
        (
            b"Content-Type: ",
            coding.content_type,
            b"\r\n",
            head.encode(),
            data,
            b"\r\n--",
            BOUNDARY,
            b"\r\n",
        )
    )


def _page(status: bytes, body: bytes, content_type: bytes = b"text/plain") -> bytes:
    head = b"HTTP/1.1 %s\r\nContent-Type: %s\r\nContent-Length: %d\r\nConnection: close\r\n\r\n"
    return head % (status, content_type, len(body)) + body
