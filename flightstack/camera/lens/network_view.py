"""Show the network its own pinhole, 90 degrees and square, through whatever lens there is.

Where each pixel of that view lies in the camera's image is computed once. An image that is much
finer than the view is averaged down first, so that nothing between two samples is lost.
"""

import math
from functools import partial

import cv2
import numpy as np
from jaxtyping import Bool, Float32
from numpy.typing import NDArray

from flightstack.arrays import Rgb
from flightstack.camera.lens.camera_info import CameraInfo
from flightstack.errors import UsageError

NETWORK_PX = 64  # what the networks look at; a view is a multiple of it
MAX_FINER = 4  # times as fine as that
HALF_VIEW = 1.0  # tan(45 degrees)
MAX_RATIO_ERROR = 0.01  # of width to height: an image may be the calibrated one, made smaller
STEPS = 1000  # along a radius, where a polynomial is looked at

View = Float32[NDArray[np.float32], "S S"]


class ImageSizeError(UsageError):
    """The camera's images have another shape than those that were calibrated."""


class NetworkView:
    """The map from a camera's image to the network's view; for one thread."""

    def __init__(self, info: CameraInfo) -> None:
        self._info = info
        self._maps = _Maps(info, info.width_px, info.height_px)

    @property
    def covered_share(self) -> float:
        """How much of the view the lens shows, 0 to 1; the rest is black."""
        return float(self._maps.seen.mean())

    def of(self, rgb: Rgb) -> Rgb:
        """Return what the network is to see of an image: square, 90 degrees in both directions.

        An image of another size than the calibrated one is taken for the whole of it, made smaller
        or larger; raises ImageSizeError where its shape says that it is not.
        """
        height, width, _ = rgb.shape
        if (width, height) != (self._maps.width_px, self._maps.height_px):
            self._check_shape(width, height)
            self._maps = _Maps(self._info, width, height)
        return self._maps.apply(rgb)

    def _check_shape(self, width: int, height: int) -> None:
        known = self._info
        if abs(width * known.height_px / (height * known.width_px) - 1.0) > MAX_RATIO_ERROR:
            raise ImageSizeError(
                f"the camera gives images of {width} x {height} pixels, but --camera-info is for "
                f"{known.width_px} x {known.height_px}: calibrate it at that size"
            )


class _Maps:
    """Where the view's pixels lie in images of one size."""

    def __init__(self, info: CameraInfo, width_px: int, height_px: int) -> None:
        self.width_px, self.height_px = width_px, height_px
        scale = np.array([width_px / info.width_px, height_px / info.height_px])
        focal_px = float(scale.min() * info.matrix.diagonal()[:2].min())
        finer = max(1, min(MAX_FINER, math.ceil(2.0 * focal_px * HALF_VIEW / NETWORK_PX)))
        self._side_px = finer * NETWORK_PX
        self._shrink = max(1, int(2.0 * focal_px * HALF_VIEW / self._side_px))
        matrix = _scaled(info.matrix, scale / self._shrink)
        small = (max(1, width_px // self._shrink), max(1, height_px // self._shrink))
        x, y = _undistorting(info, matrix, self._side_px)
        self.seen: Bool[NDArray[np.bool_], "S S"] = (
            (x >= -0.5) & (x <= small[0] - 0.5) & (y >= -0.5) & (y <= small[1] - 0.5)
        ) & _is_within(info, self._side_px)
        self._small = small
        self._maps = cv2.convertMaps(
            np.where(self.seen, np.clip(x, 0, small[0] - 1), -2).astype(np.float32),
            np.where(self.seen, np.clip(y, 0, small[1] - 1), -2).astype(np.float32),
            cv2.CV_16SC2,
        )

    def apply(self, rgb: Rgb) -> Rgb:
        if self._shrink > 1:
            rgb = np.asarray(cv2.resize(rgb, self._small, interpolation=cv2.INTER_AREA), np.uint8)
        view = cv2.remap(rgb, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(view, np.uint8)


def _scaled(matrix: NDArray[np.float64], scale: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the pinhole of an image that was made smaller: pixels' edges scale, not centres."""
    scaled = matrix.copy()
    scaled[:2, :2] *= scale[:, None]
    scaled[:2, 2] = (matrix[:2, 2] + 0.5) * scale - 0.5
    return scaled


def _undistorting(info: CameraInfo, matrix: NDArray[np.float64], side_px: int) -> tuple[View, View]:
    focal_px, centre_px = side_px / (2.0 * HALF_VIEW), (side_px - 1) / 2.0
    view = np.array([[focal_px, 0, centre_px], [0, focal_px, centre_px], [0, 0, 1.0]])
    fisheye = info.model == "equidistant"
    make = cv2.fisheye.initUndistortRectifyMap if fisheye else cv2.initUndistortRectifyMap
    x, y = make(matrix, info.coefficients, np.eye(3), view, (side_px, side_px), cv2.CV_32FC1)
    return np.asarray(x, np.float32), np.asarray(y, np.float32)


def _is_within(info: CameraInfo, side_px: int) -> Bool[NDArray[np.bool_], "S S"]:
    """Whether the lens's polynomial still says something there: farther out, it folds back."""
    radial = partial(_fisheye_radius, info) if info.model == "equidistant" else None
    radius = np.linspace(0.0, 2.0 * HALF_VIEW, STEPS)
    images = radial(radius) if radial else _polynomial_radius(info, radius)
    folds = np.flatnonzero(np.diff(images) <= 0.0)
    limit = radius[folds[0]] if folds.size else math.inf
    steps = ((np.arange(side_px) + 0.5) / side_px * 2.0 - 1.0) * HALF_VIEW
    within: Bool[NDArray[np.bool_], "S S"] = np.hypot(steps[:, None], steps[None]) <= limit
    return within


def _polynomial_radius(info: CameraInfo, radius: NDArray[np.float64]) -> NDArray[np.float64]:
    k1, k2, _, _, k3, k4, k5, k6 = np.pad(info.coefficients, (0, 8 - info.coefficients.size))
    square = radius**2
    above = 1.0 + square * (k1 + square * (k2 + square * k3))
    return np.asarray(radius * above / (1.0 + square * (k4 + square * (k5 + square * k6))))


def _fisheye_radius(info: CameraInfo, radius: NDArray[np.float64]) -> NDArray[np.float64]:
    k1, k2, k3, k4 = info.coefficients
    angle = np.arctan(radius)
    square = angle**2
    bent = 1.0 + square * (k1 + square * (k2 + square * (k3 + square * k4)))
    return np.asarray(angle * bent)
