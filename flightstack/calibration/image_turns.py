"""How far the view has turned from one image to the next, by optical flow (Lucas and Kanade).

A vehicle that is turned on the spot sees everything move by the same angle, whatever its distance.
The angle is the median over the points that could be followed there and back.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.arrays import Rgb

WIDTH_PX = 256  # images are brought to this: small ones have too little, large ones too much detail
POINTS, QUALITY, APART_PX = 150, 0.01, 5
WINDOW_PX, LEVELS = 21, 3
RETURNED_PX = 0.7  # a point that does not come back to where it was has been lost
MIN_POINTS = 10
TAN_HALF_VIEW = 1.0  # of the networks' 90 degrees; of another lens, angles are off by a factor

Grey = NDArray[np.uint8]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImageTurns:
    """Turns between images, each from one stamp to the next; clockwise seen from above."""

    from_us: NDArray[np.int64]
    to_us: NDArray[np.int64]
    angle_rad: Floats


def measure_turns(frames: Iterable[tuple[int, Rgb]]) -> ImageTurns:
    """Follow points through images with their stamps; pairs that show too little are left out."""
    rows: list[tuple[int, int, float]] = []
    before: tuple[int, Grey] | None = None
    for stamp_us, rgb in frames:
        grey = _grey(rgb)
        if before is not None and stamp_us > before[0] and before[1].shape == grey.shape:
            angle = _turn(before[1], grey)
            if angle is not None:
                rows.append((before[0], stamp_us, angle))
        before = (stamp_us, grey)
    stamps = np.array([row[:2] for row in rows], np.int64).reshape(-1, 2)
    return ImageTurns(
        from_us=stamps[:, 0], to_us=stamps[:, 1], angle_rad=np.array([row[2] for row in rows])
    )


def _grey(rgb: Rgb) -> Grey:
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    height, width = grey.shape
    way = cv2.INTER_AREA if width > WIDTH_PX else cv2.INTER_CUBIC
    size = (WIDTH_PX, max(1, round(height * WIDTH_PX / width)))
    return np.asarray(cv2.resize(grey, size, interpolation=way), np.uint8)


def _turn(before: Grey, after: Grey) -> float | None:
    corners = cv2.goodFeaturesToTrack(before, POINTS, QUALITY, APART_PX)
    if corners is None or len(corners) < MIN_POINTS:
        return None
    points = np.asarray(corners, np.float32)
    there, found = _follow(before, after, points)
    back, returned = _follow(after, before, there)
    kept = found & returned & (np.abs(back - points).max(axis=(1, 2)) < RETURNED_PX)
    if np.count_nonzero(kept) < MIN_POINTS:
        return None
    centre = (before.shape[1] - 1) / 2.0
    focal = min(before.shape) / (2.0 * TAN_HALF_VIEW)
    bearings = [np.arctan((p[kept, 0, 0] - centre) / focal) for p in (points, there)]
    angle = -float(np.median(bearings[1] - bearings[0]))  # the scene goes left: we turn right
    return angle if math.isfinite(angle) else None


def _follow(
    before: Grey, after: Grey, points: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    window = (WINDOW_PX, WINDOW_PX)
    there, status, _ = cv2.calcOpticalFlowPyrLK(
        before, after, points, np.empty_like(points), winSize=window, maxLevel=LEVELS
    )
    return np.asarray(there, np.float32), np.asarray(status.ravel() == 1)
