"""A pinhole's picture as a lens takes it: each of the lens's pixels looks along its ray."""

import cv2
import numpy as np

from flightstack.arrays import Rgb
from flightstack.camera.lens.camera_info import CameraInfo

STRONG = CameraInfo(  # bends what lies 55 degrees off its axis in by a quarter
    width_px=160,
    height_px=120,
    matrix=np.array([[56.0, 0.0, 81.5], [0.0, 55.0, 58.0], [0.0, 0.0, 1.0]]),
    model="plumb_bob",
    coefficients=np.array([-0.22, 0.035, 0.002, -0.001, -0.0015]),
)
RATIONAL = CameraInfo(
    width_px=640,
    height_px=480,
    matrix=np.array([[250.0, 0.0, 320.0], [0.0, 250.0, 236.0], [0.0, 0.0, 1.0]]),
    model="rational_polynomial",
    coefficients=np.array([0.6, 0.05, 0.0, 0.0, 0.001, 0.95, 0.2, 0.01]),
)
FISHEYE = CameraInfo(
    width_px=200,
    height_px=200,
    matrix=np.array([[70.0, 0.0, 99.0], [0.0, 70.0, 101.0], [0.0, 0.0, 1.0]]),
    model="equidistant",
    coefficients=np.array([0.02, -0.005, 0.0, 0.0]),
)
CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)


class Lens:
    """Draws a pinhole's square pictures, 90 degrees unless told otherwise, as a lens takes them."""

    def __init__(self, info: CameraInfo, side_px: int, *, focal_px: float | None = None) -> None:
        focal = side_px / 2.0 if focal_px is None else focal_px
        x, y = np.meshgrid(np.arange(info.width_px), np.arange(info.height_px))
        pixels = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float64)[:, None]
        rays = (
            cv2.fisheye.undistortPoints(pixels, info.matrix, info.coefficients)
            if info.model == "equidistant"
            else cv2.undistortPoints(pixels, info.matrix, info.coefficients, criteria=CRITERIA)
        )
        at = (rays[:, 0] * focal + (side_px - 1) / 2.0).astype(np.float32)
        shape = (info.height_px, info.width_px)
        self._maps = (at[:, 0].reshape(shape), at[:, 1].reshape(shape))

    def __call__(self, rgb: Rgb) -> Rgb:
        drawn = cv2.remap(rgb, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(drawn, np.uint8)
