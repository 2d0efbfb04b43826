"""What the parts of a film's picture have in common: colours, text, a canvas of pixels."""

import cv2
import numpy as np
from numpy.typing import NDArray

Canvas = NDArray[np.uint8]  # (height, width, 3) RGB
Colour = tuple[int, int, int]

PAPER, INK, MUTED = (18, 22, 28), (236, 240, 244), (140, 150, 162)
COMMANDED, FLOWN, GATE = (255, 196, 60), (90, 170, 255), (80, 220, 120)
PARTS = {"aleatoric": (230, 159, 0), "epistemic": (209, 73, 91), "perceptual": (42, 157, 143)}
FONT, SMALL, LINE = cv2.FONT_HERSHEY_SIMPLEX, 0.42, 18


def blank(height: int, width: int) -> Canvas:
    """Return an empty canvas."""
    return np.full((height, width, 3), PAPER, dtype=np.uint8)


def write(canvas: Canvas, text: str, at: tuple[int, int], colour: Colour = INK) -> None:
    """Write one line, its lower left corner at (x, y); what the font lacks becomes '?'."""
    plain = text.encode("ascii", "replace").decode()
    cv2.putText(canvas, plain, at, FONT, SMALL, colour, 1, cv2.LINE_AA)


def polyline(canvas: Canvas, points: NDArray[np.float64], colour: Colour, width: int = 1) -> None:
    """Draw a line through points (n, 2) of x and y; what is not finite is left out."""
    known = points[np.isfinite(points).all(axis=1)]
    if len(known) > 1:
        pixels = np.clip(known, -1e4, 1e4).round().astype(np.int32)
        cv2.polylines(canvas, [pixels], isClosed=False, color=colour, thickness=width)


def disc(canvas: Canvas, at: tuple[float, float], radius: int, colour: Colour) -> None:
    """Draw a filled disc."""
    centre = (round(at[0]), round(at[1]))
    cv2.circle(canvas, centre, radius, colour, cv2.FILLED, cv2.LINE_AA)
