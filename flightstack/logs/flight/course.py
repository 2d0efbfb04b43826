"""The gates of a course and what became of them, as the referee component told it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.flight.texts import LoggedText
from flightstack.mavlink_numbers import REFEREE_COMPONENT

LOCAL_SCALE = 1e-4  # MISSION_ITEM_INT counts local x and y in 0.1 mm
LOCAL_NED = 1
DEFAULT_HALF_OPENING_M = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseGate:
    """One gate: a square opening."""

    index: int
    centre_ned: tuple[float, float, float]  # m
    yaw_rad: float  # heading of the axis along which it is passed
    half_opening_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseEvent:
    """Something that the referee said."""

    time_us: int
    kind: str  # "passed", "missed", "collision", "finished" or "other"
    text: str

    @property
    def is_failure(self) -> bool:
        """Whether the course ended here without success."""
        return self.kind in ("missed", "collision")


def find_gates(log: Log) -> list[CourseGate]:
    """Return the gates that the referee listed as mission items, in order; often none."""
    items = log["MISSION_ITEM_INT"].where(component=REFEREE_COMPONENT)
    items = items.take(items["frame"] == LOCAL_NED)
    _, first = np.unique(items["seq"], return_index=True)
    items = items.take(first)
    columns = [items[name].tolist() for name in ("seq", "x", "y", "z", "param2", "param4")]
    return [
        CourseGate(
            index=seq,
            centre_ned=(x * LOCAL_SCALE, y * LOCAL_SCALE, z),
            yaw_rad=float(np.radians(heading)),
            half_opening_m=half if 0 < half < 100 else DEFAULT_HALF_OPENING_M,
        )
        for seq, x, y, z, half, heading in zip(*columns, strict=True)
        if np.isfinite(z) and np.isfinite(heading)
    ]


def gate_outline(gate: CourseGate) -> NDArray[np.float64]:
    """Return the corners of a gate's opening as a closed line, (5, 3) north, east, down."""
    across = np.array([-np.sin(gate.yaw_rad), np.cos(gate.yaw_rad), 0.0])
    up = np.array([0.0, 0.0, -1.0])
    centre, half = np.array(gate.centre_ned), gate.half_opening_m
    corners = [(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]
    return np.array([centre + half * (a * across + b * up) for a, b in corners])


def _kind(text: str) -> str:
    start = text.lower()
    kinds = {"passed": "passed", "missed": "missed", "collision": "collision"}
    found = next((kind for prefix, kind in kinds.items() if start.startswith(prefix)), None)
    return found or ("finished" if "finished" in start or "complete" in start else "other")


def find_events(texts: list[LoggedText]) -> list[CourseEvent]:
    """Return what the referee said, in order of time."""
    return [
        CourseEvent(time_us=text.time_us, kind=_kind(text.text), text=text.text)
        for text in texts
        if text.component == REFEREE_COMPONENT
    ]


def gates_passed(log: Log) -> int:
    """Return how many gates the referee counted as passed."""
    reached = log["MISSION_ITEM_REACHED"].where(component=REFEREE_COMPONENT)
    return len(np.unique(reached["seq"]))
