"""Read any camera that OpenCV opens: a device, an RTSP or HTTP stream, a video file."""

import os
import threading
from pathlib import Path

import cv2
import numpy as np

from flightstack.camera.mailbox import Arrival
from flightstack.clock import VehicleClock
from flightstack.records import Image

OPEN_TIMEOUT_MS = 5000
READ_TIMEOUT_MS = 5000
DEFAULT_RATE_HZ = 20.0  # of a video file that does not say

# Errors are ours to tell, in one line. OpenCV reads this when it first needs FFmpeg.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")


class CaptureSource:
    """An opened cv2.VideoCapture; images are stamped with the vehicle's clock as they come."""

    stamped = False

    def __init__(self, uri: str, clock: VehicleClock) -> None:
        self._clock = clock
        self._count = 0
        self._closed = threading.Event()
        self._capture = _open(uri)
        if not self._capture.isOpened():
            raise OSError(0, "OpenCV cannot open it")
        self._period_s = _file_period_s(uri, self._capture)
        self._next_s = self._clock.wall_s()

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when the camera gives no more."""
        self._pace()
        good, bgr = self._capture.read()
        received_s = self._clock.wall_s()
        if not good or self._closed.is_set():
            raise OSError(0, "the camera gives no more frames")
        self._count += 1
        rgb = np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
        image = Image(stamp_us=self._clock.now_us(), sequence=self._count, rgb=rgb)
        return Arrival(image, received_s)

    def close(self) -> None:
        """End reading; a `read` that waits in another thread returns with an error."""
        self._closed.set()

    def _pace(self) -> None:
        """Play a file at its own rate; a camera keeps time by itself."""
        if self._period_s is None:
            return
        self._closed.wait(max(0.0, self._next_s - self._clock.wall_s()))
        self._next_s = max(self._next_s + self._period_s, self._clock.wall_s())


def _open(uri: str) -> cv2.VideoCapture:
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    if uri.isdecimal():
        return cv2.VideoCapture(int(uri))
    if "://" not in uri:
        return cv2.VideoCapture(uri)
    timeouts = [
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
        OPEN_TIMEOUT_MS,
        cv2.CAP_PROP_READ_TIMEOUT_MSEC,
        READ_TIMEOUT_MS,
    ]
    return cv2.VideoCapture(uri, cv2.CAP_FFMPEG, timeouts)


def _file_period_s(uri: str, capture: cv2.VideoCapture) -> float | None:
    if not Path(uri).is_file():
        return None
    rate_hz = capture.get(cv2.CAP_PROP_FPS)
    return 1.0 / (rate_hz if rate_hz > 0 else DEFAULT_RATE_HZ)
