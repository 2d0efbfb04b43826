"""Open a video device (V4L2) with the size, rate and exposure that it is asked for.

A device takes the nearest that it has, and says nothing: what it then has is read back, and another
size or rate than was asked for is refused.
"""

import re

import cv2

from flightstack.camera.settings import DeviceSettings
from flightstack.errors import UsageError

DEVICE = re.compile(r"(\d+)|(/dev/video\d+)")
BUFFERS = 1  # a further one is a picture of delay
MANUAL_EXPOSURE = 1  # V4L2_EXPOSURE_MANUAL
EXPOSURE_STEP_S = 1e-4  # V4L2_CID_EXPOSURE_ABSOLUTE counts 100 us
COMPRESSED = cv2.VideoWriter.fourcc(*"MJPG")  # USB 2 carries large images at a low rate only
RATE_TOLERANCE = 0.05
EXPOSURE_TOLERANCE = 0.2
MAX_AGE_S = 1.0  # of a time that a driver may tell; others count since 1970, or are 0


def is_device(uri: str) -> bool:
    """Whether a camera's name is that of a video device: 0, /dev/video0."""
    return DEVICE.fullmatch(uri) is not None


def open_device(uri: str, settings: DeviceSettings) -> cv2.VideoCapture:
    """Open a device; whoever called looks whether it is opened. Raises UsageError."""
    where = int(uri) if uri.isdecimal() else uri
    if not settings.asks:
        return cv2.VideoCapture(where)
    capture = cv2.VideoCapture(where, cv2.CAP_V4L2)
    if capture.isOpened():
        capture.set(cv2.CAP_PROP_BUFFERSIZE, BUFFERS)
        _set_pictures(capture, settings)
        if not _has_pictures(capture, settings):
            capture.set(cv2.CAP_PROP_FOURCC, COMPRESSED)
            _set_pictures(capture, settings)
        _set_exposure(capture, settings)
        _check(uri, capture, settings)
    return capture


def taken_s(capture: cv2.VideoCapture, received_s: float) -> float | None:
    """Return when the newest image was taken, monotonic seconds; None where its driver tells none.

    Drivers stamp buffers with the monotonic clock, which is ours, at the start of a frame.
    """
    told_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
    return told_s if 0.0 < received_s - told_s < MAX_AGE_S else None


def _set_pictures(capture: cv2.VideoCapture, settings: DeviceSettings) -> None:
    if settings.size_px is not None:
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, settings.size_px[0])
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, settings.size_px[1])
    if settings.rate_hz is not None:
        capture.set(cv2.CAP_PROP_FPS, settings.rate_hz)


def _has_pictures(capture: cv2.VideoCapture, settings: DeviceSettings) -> bool:
    size_px, rate_hz = _pictures(capture)
    has_size = settings.size_px in (None, size_px)
    wanted_hz = settings.rate_hz
    return has_size and (wanted_hz is None or abs(rate_hz / wanted_hz - 1.0) < RATE_TOLERANCE)


def _pictures(capture: cv2.VideoCapture) -> tuple[tuple[int, int], float]:
    width, height = (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)
    size_px = (round(capture.get(width)), round(capture.get(height)))
    return size_px, capture.get(cv2.CAP_PROP_FPS)


def _set_exposure(capture: cv2.VideoCapture, settings: DeviceSettings) -> None:
    if settings.exposure_s is not None:
        capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL_EXPOSURE)
        capture.set(cv2.CAP_PROP_EXPOSURE, round(settings.exposure_s / EXPOSURE_STEP_S))


def _check(uri: str, capture: cv2.VideoCapture, settings: DeviceSettings) -> None:
    if not _has_pictures(capture, settings):
        (width, height), rate_hz = _pictures(capture)
        capture.release()
        raise UsageError(
            f"camera {uri} gives {width} x {height} at {rate_hz:g} images a second, not what "
            "--camera-size and --camera-rate ask for: v4l2-ctl --list-formats-ext lists what it has"
        )
    exposure_s = capture.get(cv2.CAP_PROP_EXPOSURE) * EXPOSURE_STEP_S
    wanted_s = settings.exposure_s
    if wanted_s is not None and abs(exposure_s / wanted_s - 1.0) > EXPOSURE_TOLERANCE:
        capture.release()
        raise UsageError(
            f"camera {uri} exposes for {1e3 * exposure_s:g} ms, not for the {1e3 * wanted_s:g} of "
            "--camera-exposure-s: v4l2-ctl --list-ctrls lists what it can"
        )
