"""Draw what the networks see, beside the whole image of the camera."""

import argparse

import cv2
import numpy as np

from flightstack.arrays import Rgb
from flightstack.calibration.recordings import read_recording
from flightstack.camera.lens.camera_info import read_camera_info
from flightstack.camera.lens.network_view import NETWORK_PX, NetworkView
from flightstack.errors import UsageError

HEIGHT_PX = 512  # of either half of the picture
GAP_PX = 8


def run(options: argparse.Namespace) -> str:
    """Draw the first image of the recording; return what there is to say."""
    rgb = next(iter(read_recording(options.recording)))
    seen, told = _seen(options, rgb)
    small = cv2.resize(seen, (NETWORK_PX, NETWORK_PX), interpolation=cv2.INTER_AREA)
    left = cv2.resize(rgb, (round(rgb.shape[1] * HEIGHT_PX / rgb.shape[0]), HEIGHT_PX))
    right = cv2.resize(small, (HEIGHT_PX, HEIGHT_PX), interpolation=cv2.INTER_NEAREST)
    gap = np.full((HEIGHT_PX, GAP_PX, 3), 255, np.uint8)
    drawn = cv2.cvtColor(np.hstack([left, gap, right]), cv2.COLOR_RGB2BGR)
    try:
        written = cv2.imwrite(str(options.output), drawn)
    except cv2.error:
        written = False
    if not written:
        raise UsageError(f"cannot write {options.output}: name a .png or .jpg in a folder that is")
    return f"{options.output}: the camera's image, and what the networks see of it: {told}"


def _seen(options: argparse.Namespace, rgb: Rgb) -> tuple[Rgb, str]:
    if options.camera_info is None:
        side = min(rgb.shape[:2])
        top, left = (rgb.shape[0] - side) // 2, (rgb.shape[1] - side) // 2
        return rgb[top : top + side, left : left + side], "the middle square as it is"
    view = NetworkView(read_camera_info(options.camera_info))
    share = 100 * view.covered_share
    return view.of(rgb), f"90 x 90 degrees, {share:.0f} % of them shown by the lens"
