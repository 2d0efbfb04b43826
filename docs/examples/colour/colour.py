"""Fly through gates by their colour alone: classical vision with OpenCV, nothing learned."""

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.records import Observation

SIZE_PX, CENTRE_PX, FOCAL_PX = 64, 32.0, 32.0  # 90 degrees wide
NEAR_PX2, FAR_PX2 = 150, 12  # area of a frame that is cut off; of one that is heeded
SPEED_M_S, SEARCH_RAD_S, TURN_PER_RAD = 1.6, 0.6, 1.6
PASSING_IMAGES = 16  # straight on, once the gate is too near to be seen whole


class ColourPilot:
    """Look for the largest red to yellow frame, and fly to the middle of it."""

    def __init__(self, *, direction: str, seed: int) -> None:  # noqa: ARG002  no chance in it
        self._side = 1.0 if direction == "cw" else -1.0  # where the course bends to
        self.reset()

    def reset(self) -> None:
        """Forget the last flight."""
        self._before, self._blind = np.zeros(4), 0

    def act(self, observation: Observation) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Answer an image by velocities, less sure of them the smaller the gate is."""
        seen = find_gate(observation.image)
        if seen is None:
            self._blind += 1
            if self._blind > PASSING_IMAGES:  # none there: look where the course bends to
                self._before = np.array([SPEED_M_S / 3, 0.0, 0.0, self._side * SEARCH_RAD_S])
            return self._before * [1.0, 1.0, 1.0, self._blind > PASSING_IMAGES], np.full(4, 0.6)
        (x_px, y_px), area_px2 = seen
        self._blind, right = 0, np.arctan2(x_px - CENTRE_PX, FOCAL_PX)
        down = np.arctan2(y_px - CENTRE_PX, FOCAL_PX) - observation.attitude[1]  # its pitch
        ahead = np.array([np.cos(right), np.sin(right), np.tan(down), TURN_PER_RAD * right])
        self._before = ahead * [SPEED_M_S, SPEED_M_S, SPEED_M_S, 1.0]
        return self._before, np.full(4, 1.0 / np.sqrt(area_px2))


def find_gate(image: NDArray[np.uint8]) -> tuple[tuple[float, float], float] | None:
    """Return middle (px) and area (px^2) of the largest frame in a gate's colours.

    None where there is none, or one so near that the image does not hold it whole.
    """
    red, green, blue = cv2.split(image.astype(np.float32))
    framed = np.asarray((blue < 0.45 * red) & (green < 0.75 * red) & (red > 40.0), np.uint8)
    _, _, boxes, _ = cv2.connectedComponentsWithStats(framed)
    largest = max(boxes[1:], key=lambda box: box[2] * box[3], default=None)
    if largest is None or largest[2] * largest[3] < FAR_PX2:
        return None
    x, y, width, height, _ = map(int, largest)
    cut_off = min(x, y) == 0 or max(x + width, y + height) == SIZE_PX
    if cut_off and width * height > NEAR_PX2:
        return None
    return (x + width / 2.0, y + height / 2.0), float(width * height)
