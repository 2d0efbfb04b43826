"""Draw what the camera saw, the gate that was due in it, and the command as an arrow."""

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.frames import rotation_ned_frd
from flightstack.logs.flight.course import CourseGate, gate_outline
from flightstack.logs.video.drawing import COMMANDED, GATE, Canvas, polyline

MIN_AHEAD_M = 0.05  # what is nearer has no place in the picture
M_S_ACROSS = 6.0  # a command this fast reaches the picture's edge

Floats = NDArray[np.float64]


def enlarged(path: str, side: int) -> Canvas:
    """Return an image as a square of that many pixels, its own pixels as they are."""
    read = cv2.imread(path, cv2.IMREAD_COLOR)
    if read is None:  # a file that a full disk cut
        return np.zeros((side, side, 3), dtype=np.uint8)
    height, width = read.shape[:2]
    scale = side / max(height, width)
    size = (max(round(width * scale), 1), max(round(height * scale), 1))
    picture = cv2.resize(cv2.cvtColor(read, cv2.COLOR_BGR2RGB), size, interpolation=_way(scale))
    canvas = np.zeros((side, side, 3), dtype=np.uint8)
    top, left = (side - size[1]) // 2, (side - size[0]) // 2
    canvas[top : top + size[1], left : left + size[0]] = picture
    return canvas


def _way(scale: float) -> int:
    return cv2.INTER_NEAREST if scale > 1 else cv2.INTER_AREA


def draw_gate(canvas: Canvas, gate: CourseGate, position_ned: Floats, attitude_rad: Floats) -> None:
    """Draw where a gate's opening is by the referee's list and the vehicle's own estimate.

    For a camera that sees 90 degrees both ways, forward from the body's origin.
    """
    frd = (gate_outline(gate) - position_ned) @ rotation_ned_frd(attitude_rad)
    half = canvas.shape[0] / 2
    if not (frd[:, 0] > MIN_AHEAD_M).all():
        return
    polyline(canvas, half + half * frd[:, 1:] / frd[:, :1], GATE, 2)


def draw_command(canvas: Canvas, command: Floats) -> None:
    """Draw a command (4,): right and down as an arrow from the middle."""
    half = canvas.shape[0] / 2
    middle = (round(half), round(half))
    tip = np.clip(half + half * command[1:3] / M_S_ACROSS, 0, 2 * half)
    end = (round(float(tip[0])), round(float(tip[1])))
    cv2.arrowedLine(canvas, middle, end, COMMANDED, 2, cv2.LINE_AA, tipLength=0.25)
