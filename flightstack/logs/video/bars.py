"""Draw the command beside what was flown, and the parts of the uncertainty, as bars."""

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.logs.flight.decisions import LINEAR, UNITS, VELOCITIES, Decisions
from flightstack.logs.video.drawing import (
    COMMANDED,
    FLOWN,
    LINE,
    MUTED,
    PARTS,
    Canvas,
    Colour,
    blank,
    write,
)

FULL_COMMAND, FULL_STD_M_S = (6.0, 6.0, 6.0, 2.0), 2.0  # as long as a bar gets
NAME_PX, VALUE_PX = 90, 95

Floats = NDArray[np.float64]


def command_bars(width: int, command: Floats | None, flown: Floats) -> Canvas:
    """Return bars of four velocities (4,), commanded above flown, from the middle out."""
    canvas = blank(LINE * (len(VELOCITIES) + 1), width)
    write(canvas, "command", (8, LINE - 5), COMMANDED)
    write(canvas, "flown", (80, LINE - 5), FLOWN)
    room = (width - NAME_PX - VALUE_PX) / 2
    for row, (name, unit) in enumerate(zip(VELOCITIES, UNITS, strict=True), start=1):
        top, middle = row * LINE, NAME_PX + room
        write(canvas, name, (8, top + LINE - 5), MUTED)
        full = room / FULL_COMMAND[row - 1]
        if command is not None:
            _bar(canvas, (middle, top + 3), float(command[row - 1]) * full, COMMANDED)
            text = f"{command[row - 1]:+.2f} {unit}"
            write(canvas, text, (width - VALUE_PX + 4, top + LINE - 5), MUTED)
        _bar(canvas, (middle, top + 10), float(flown[row - 1]) * full, FLOWN)
    return canvas


def uncertainty_bars(width: int, decisions: Decisions, row: int | None) -> Canvas:
    """Return bars of the parts of the uncertainty: lengths over vx, vy, vz, m/s."""
    canvas = blank(LINE * (len(PARTS) + 1), width)
    write(canvas, "uncertainty", (8, LINE - 5), MUTED)
    for place, (name, colour) in enumerate(PARTS.items(), start=1):
        write(canvas, name, (8, place * LINE + LINE - 5), MUTED)
        if row is None:
            continue
        std_m_s = float(np.linalg.norm(getattr(decisions, f"{name}_std")[row, LINEAR]))
        length = min(std_m_s / FULL_STD_M_S, 1.0) * (width - NAME_PX - VALUE_PX)
        _bar(canvas, (NAME_PX, place * LINE + 6), length, colour)
        text = f"{std_m_s:.2f} m/s"
        write(canvas, text, (width - VALUE_PX + 4, place * LINE + LINE - 5), MUTED)
    return canvas


def _bar(canvas: Canvas, at: tuple[float, float], length: float, colour: Colour) -> None:
    if not np.isfinite(length):
        return
    low, high = sorted((at[0], at[0] + length))
    corner, other = (round(low), round(at[1])), (round(high), round(at[1]) + 5)
    cv2.rectangle(canvas, corner, other, colour, cv2.FILLED)
