"""Read any camera that OpenCV opens: a device, an RTSP or HTTP stream, a video file."""

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from flightstack.camera.mailbox import Arrival
from flightstack.camera.picture_size import MAX_PIXELS
from flightstack.camera.settings import DeviceSettings
from flightstack.camera.video_device import is_device, open_device, taken_s
from flightstack.clock import VehicleClock
from flightstack.records import Image

OPEN_TIMEOUT_S = 5.0
READ_TIMEOUT_MS = 5000
AS_IT_IS = DeviceSettings()
DEFAULT_RATE_HZ = 20.0  # of a video file that does not say

# What may be in a stream whose address the vehicle named: nothing that names another address.
STREAMS_ONLY = (
    "protocol_whitelist;udp,rtp,rtsp,tcp,tls,srtp|"
    "format_whitelist;mpegts,rtp,rtsp,sdp,h264,hevc,mjpeg,mpjpeg|rtsp_flags;prefer_tcp"
)
CAPTURE_OPTIONS = "OPENCV_FFMPEG_CAPTURE_OPTIONS"  # read by OpenCV whenever it opens something

# Errors are ours to tell, in one line. OpenCV reads this when it first needs FFmpeg.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")


class CaptureSource:
    """An opened cv2.VideoCapture; images are stamped with the vehicle's clock as they come."""

    def __init__(
        self,
        uri: str,
        clock: VehicleClock,
        *,
        trusted: bool = True,
        timeout_s: float = OPEN_TIMEOUT_S,
        device: DeviceSettings = AS_IT_IS,
    ) -> None:
        """Open a camera; of an address that is not trusted, streams alone are read.

        Raises OSError where it cannot be, UsageError where a device does not do what it is asked.
        """
        self._clock = clock
        self._count = 0
        self._closed = threading.Event()
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        self._is_device = trusted and is_device(uri)
        if self._is_device:
            self._capture = open_device(uri, device)
        elif trusted:
            self._capture = _open(uri, timeout_s)
        else:
            with _streams_only():
                self._capture = _open_address(uri, timeout_s)
        if not self._capture.isOpened():
            raise OSError(0, "OpenCV cannot open it")
        width_px = self._capture.get(cv2.CAP_PROP_FRAME_WIDTH)
        height_px = self._capture.get(cv2.CAP_PROP_FRAME_HEIGHT)
        if width_px * height_px > MAX_PIXELS:
            raise OSError(0, f"images of {width_px:.0f} x {height_px:.0f} pixels are too large")
        self._period_s = _file_period_s(uri, self._capture)
        self._next_s = self._clock.wall_s()

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when the camera gives no more."""
        self._pace()
        good, bgr = self._capture.read()
        received_s = self._clock.wall_s()
        if not good or self._closed.is_set() or bgr.size > 3 * MAX_PIXELS:
            self._capture.release()  # a device opens once
            raise OSError(0, "the camera gives no more frames")
        self._count += 1
        rgb = np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
        exposed_s = taken_s(self._capture, received_s) if self._is_device else None
        known_s = received_s if exposed_s is None else exposed_s
        image = Image(stamp_us=self._clock.at_us(known_s), sequence=self._count, rgb=rgb)
        return Arrival(image, received_s, stamped=False, taken_s=exposed_s)

    def close(self) -> None:
        """End reading; a `read` that waits in another thread returns with an error."""
        self._closed.set()

    def _pace(self) -> None:
        """Play a file at its own rate; a camera keeps time by itself."""
        if self._period_s is None:
            return
        self._closed.wait(max(0.0, self._next_s - self._clock.wall_s()))
        self._next_s = max(self._next_s + self._period_s, self._clock.wall_s())


@contextlib.contextmanager
def _streams_only() -> Iterator[None]:
    before = os.environ.get(CAPTURE_OPTIONS)
    os.environ[CAPTURE_OPTIONS] = STREAMS_ONLY
    try:
        yield
    finally:
        os.environ.pop(CAPTURE_OPTIONS)
        if before is not None:
            os.environ[CAPTURE_OPTIONS] = before


def _open(uri: str, timeout_s: float) -> cv2.VideoCapture:
    return _open_address(uri, timeout_s) if "://" in uri else cv2.VideoCapture(uri)


def _open_address(uri: str, timeout_s: float) -> cv2.VideoCapture:
    timeouts = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
        max(1, round(timeout_s * 1000)),
        cv2.CAP_PROP_READ_TIMEOUT_MSEC,
        READ_TIMEOUT_MS,
    ]
    return cv2.VideoCapture(uri, cv2.CAP_FFMPEG, timeouts)


def _file_period_s(uri: str, capture: cv2.VideoCapture) -> float | None:
    if not Path(uri).is_file():
        return None
    rate_hz = capture.get(cv2.CAP_PROP_FPS)
    return 1.0 / (rate_hz if rate_hz > 0 else DEFAULT_RATE_HZ)
