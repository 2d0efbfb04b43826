"""The options that say which camera there is, and what is known of it."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flightstack.camera.settings import CameraSettings

MAX_LATENCY_S = 2.0  # beyond that the vehicle is landed for want of images


def add_camera_options(parser: argparse.ArgumentParser) -> None:
    """Add them as a group of their own."""
    add = parser.add_argument_group("camera").add_argument
    add("--camera", metavar="URI", help="stream, device or file (default: what the vehicle names)")
    add("--camera-host", metavar="HOST", help="where a named camera may be, beside the vehicle's")
    add("--camera-info", type=Path, metavar="FILE", help="calibration of its lens: ROS's YAML")
    add("--camera-size", type=_size, metavar="WxH", help="of a video device's images, pixels")
    add("--camera-rate", type=_positive, metavar="HZ", help="of a video device")
    add("--camera-exposure-s", type=_positive, metavar="S", help="of a video device, by hand")
    add("--camera-latency-s", type=_latency, default=0.0, metavar="S", help="of undated images (0)")


def camera_settings(arguments: argparse.Namespace) -> "CameraSettings":
    """Read what they say; raises UsageError."""
    # Here, not above: --help must not wait for OpenCV.
    from flightstack.camera.lens.camera_info import read_camera_info  # noqa: PLC0415
    from flightstack.camera.lens.network_view import NetworkView  # noqa: PLC0415
    from flightstack.camera.settings import CameraSettings, DeviceSettings  # noqa: PLC0415

    file = arguments.camera_info
    return CameraSettings(
        view=None if file is None else NetworkView(read_camera_info(file)),
        device=DeviceSettings(
            size_px=arguments.camera_size,
            rate_hz=arguments.camera_rate,
            exposure_s=arguments.camera_exposure_s,
        ),
        latency_s=arguments.camera_latency_s,
    )


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal() and int(width) and int(height)):
        raise argparse.ArgumentTypeError(f"{text} is not a size like 1280x720")
    return int(width), int(height)


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text} is not a number above 0")
    return value


def _latency(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= MAX_LATENCY_S:
        raise argparse.ArgumentTypeError(f"{text} is not a number from 0 to {MAX_LATENCY_S:g}")
    return value
