"""Read the parts of a multipart stream: a few headers, one coded image, and what they mean.

Nothing that a server sends is believed: headers are counted, and a picture's size is known before
it is decoded.
"""

from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.camera.picture_size import is_welcome

MAX_PART_BYTES = 64 << 20
MAX_LINE_BYTES = 4096
MAX_LINES = 64  # of a part's headers
MAX_DIGITS = 15
MAX_STAMP_S = 2**32 / 1000  # MAVLink counts vehicle time in 32 bits of milliseconds: 49.7 days


class ByteStream(Protocol):
    """The body of an answer."""

    def readline(self, limit: int, /) -> bytes:
        """Read a line, or as much of it as the limit allows; empty at the end."""

    def read(self, size: int, /) -> bytes:
        """Read so many bytes, or what is left."""


def read_part(stream: ByteStream) -> tuple[dict[str, str], bytes]:
    """Read one part: headers by lower-case name, and content; OSError where there is none."""
    headers = _read_headers(stream)
    length = read_number(headers.get("content-length", ""), -1)
    if not 0 <= length <= MAX_PART_BYTES:
        raise OSError(0, f"a part of {length} bytes: Content-Length is missing or wrong")
    content = stream.read(length)
    if len(content) < length:
        raise OSError(0, "the stream has ended within a frame")
    return headers, content


def decode_rgb(content: bytes) -> NDArray[np.uint8] | None:
    """Decode a PNG or JPEG into (H, W, 3) RGB; None where it is damaged, none or too large."""
    if not is_welcome(content):
        return None
    try:
        bgr = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:  # a header that contradicts its data
        return None
    return None if bgr is None else np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def read_stamp_us(text: str) -> int | None:
    """Read seconds of vehicle time; None where they are none that a vehicle can tell."""
    try:
        stamp_s = float(text)
    except ValueError:
        return None
    return round(stamp_s * 1e6) if 0.0 <= stamp_s < MAX_STAMP_S else None  # NaN neither


def read_number(text: str, otherwise: int) -> int:
    """Read the number of an image, if it is one that a flight can reach."""
    return int(text) if text.isdecimal() and len(text) <= MAX_DIGITS else otherwise


def _read_headers(stream: ByteStream) -> dict[str, str]:
    headers: dict[str, str] = {}
    for _ in range(MAX_LINES):
        line = stream.readline(MAX_LINE_BYTES)
        if not line:
            raise OSError(0, "the stream has ended")
        name, colon, value = line.decode("latin-1").partition(":")
        if colon:
            headers[name.strip().lower()] = value.strip()
        elif headers and not line.strip():
            return headers
    raise OSError(0, f"a part of more than {MAX_LINES} header lines")
