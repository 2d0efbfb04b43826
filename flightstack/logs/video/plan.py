"""Draw the path and the gates from above, up to a moment."""

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.logs.flight.course import gate_outline
from flightstack.logs.flight.flight import Flight
from flightstack.logs.seen import SeenImages
from flightstack.logs.video.drawing import (
    COMMANDED,
    FLOWN,
    GATE,
    INK,
    MUTED,
    Canvas,
    blank,
    disc,
    polyline,
    write,
)

MARGIN_PX, MIN_EXTENT_M, HEADING_PX = 34, 4.0, 18

Floats = NDArray[np.float64]


class PathPlan:
    """The view from above, north up; what does not change is drawn once."""

    def __init__(self, flight: Flight, seen: SeenImages, side: int) -> None:
        self._side = side
        self._seen = seen
        centres = np.array([gate.centre_ned for gate in flight.gates]).reshape(-1, 3)
        placed = np.vstack([seen.position_ned, centres])[:, :2]
        placed = placed[np.isfinite(placed).all(axis=1)]
        low, high = (placed.min(axis=0), placed.max(axis=0)) if len(placed) else (0.0, 0.0)
        self._middle = np.asarray((low + high) / 2 + np.zeros(2))
        extent_m = max(float(np.max(high - low)), MIN_EXTENT_M)
        self._pixels_a_m = (side - 2 * MARGIN_PX) / extent_m
        self._gates = flight.gates
        self._path = self._places(seen.position_ned)
        self._ground = blank(side, side)
        polyline(self._ground, self._path, (48, 56, 66))
        write(self._ground, "north up", (side - 78, side - 10), MUTED)

    def at(self, row: int) -> Canvas:
        """Return the view when the image of that row was taken."""
        canvas = self._ground.copy()
        count = len(self._gates)
        due = int(self._seen.gates_passed[row]) % count if count else 0
        for gate in self._gates:
            colour = GATE if gate.index == due else MUTED
            places = self._places(gate_outline(gate))
            polyline(canvas, places, colour, 3)
            x, y = places.mean(axis=0).round().astype(int).tolist()
            write(canvas, str(gate.index + 1), (x + 8, y - 6), colour)
        polyline(canvas, self._path[: row + 1], FLOWN, 2)
        self._vehicle(canvas, row)
        return canvas

    def _vehicle(self, canvas: Canvas, row: int) -> None:
        x, y = self._path[row].tolist()
        yaw = float(self._seen.attitude_rad[row, 2])
        if not np.isfinite([x, y, yaw]).all():
            return
        tip = (round(x + HEADING_PX * np.sin(yaw)), round(y - HEADING_PX * np.cos(yaw)))
        cv2.line(canvas, (round(x), round(y)), tip, COMMANDED, 2, cv2.LINE_AA)
        disc(canvas, (x, y), 5, INK)

    def _places(self, points_ned: Floats) -> Floats:
        """Return pixels (n, 2), x to the east and y to the south."""
        north, east = ((points_ned[:, :2] - self._middle) * self._pixels_a_m).T
        return np.stack([self._side / 2 + east, self._side / 2 - north], axis=1)
