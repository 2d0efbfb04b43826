"""Find the part of an image that gates can be in: nothing else need be rasterised."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sitl.records.course import Gate

MARGIN_PX = 2  # a rasteriser rounds
RING_REACH = 1.0 / math.cos(math.pi / 12.0)  # of a ring's corners, beyond its circle
SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)


class Window(NamedTuple):
    """Columns and rows of an image, from the first to before the last; all even."""

    left: int
    top: int
    right: int
    bottom: int


class GateWindow:
    """Knows where gates stand, and looks where they are in an image of a pinhole camera."""

    def __init__(self, *, size_px: int, reach: float, near_m: float, far_m: float) -> None:
        """Know a camera: `reach` is the tangent of half its field of view; `size_px` is even."""
        self.whole = Window(0, 0, size_px, size_px)
        self._half_px, self._reach = size_px / 2.0, reach
        self._near_m, self._far_m = near_m, far_m
        self._corners = np.empty((0, 3))  # of the boxes around all gates, NED

    def place_gates(self, gates: tuple[Gate, ...]) -> None:
        """Put boxes around the gates."""
        self._corners = np.concatenate([_corners(gate) for gate in gates] or [np.empty((0, 3))])

    def look(
        self, position_ned: NDArray[np.float32], rotation_ned_frd: NDArray[np.float32]
    ) -> Window | None:
        """Return where gates can be in the image; None if nowhere.

        The whole image, where a gate reaches from behind the camera to before it.
        """
        seen = (self._corners - position_ned) @ rotation_ned_frd  # FRD
        ahead = seen[:, 0].reshape(-1, len(SIGNS))
        nearest = ahead.min(axis=1)
        before = (nearest < self._far_m) & (ahead.max(axis=1) > self._near_m)
        if not before.any():
            return None
        if nearest[before].min() <= self._near_m:
            return self.whole
        rays = seen.reshape(-1, len(SIGNS), 3)[before]
        at = (rays[:, :, 1:] / rays[:, :, :1] / self._reach + 1.0) * self._half_px
        low, high = at.min(axis=1), at.max(axis=1)
        visible = ((high > 0.0) & (low < 2.0 * self._half_px)).all(axis=1)
        if not visible.any():
            return None
        left, top = low[visible].min(axis=0).tolist()
        right, bottom = high[visible].max(axis=0).tolist()
        return Window(*(self._before(edge) for edge in (left, top)),
                      *(self._after(edge) for edge in (right, bottom)))  # fmt: skip

    def _before(self, edge_px: float) -> int:
        return max(0, math.floor(edge_px) - MARGIN_PX) // 2 * 2

    def _after(self, edge_px: float) -> int:
        return min(self.whole.right, (math.ceil(edge_px) + MARGIN_PX + 1) // 2 * 2)


def _corners(gate: Gate) -> NDArray[np.float64]:
    """Return the corners (8, 3) of a box around a gate, NED."""
    shape = gate.shape
    half_m = shape.outer_m / 2.0 * (RING_REACH if shape.outline == "circle" else 1.0)
    box = SIGNS * (shape.depth_m / 2.0, half_m, half_m)
    cos, sin = math.cos(gate.yaw_rad), math.sin(gate.yaw_rad)
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    corners: NDArray[np.float64] = box @ turned.T + gate.centre_ned
    return corners
