"""The course: its gates, and what the referee saw."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from sitl.records.gate import STANDARD_SHAPE, GateShape
from sitl.records.motion import Vector3

Direction = Literal["cw", "ccw"]  # seen from above


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """One gate of a course: an opening that is passed along its axis."""

    index: int
    centre_ned: Vector3  # m
    yaw_rad: float  # heading of the axis along which the gate is to be passed, NED
    shape: GateShape = STANDARD_SHAPE


class CourseState(StrEnum):
    """Where the course stands."""

    ACTIVE = "active"
    FINISHED = "finished"
    FAILED = "failed"


class CourseEventKind(StrEnum):
    """What the referee saw."""

    PASSED = "passed"
    MISSED = "missed"
    COLLISION = "collision"
    FINISHED = "finished"


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseEvent:
    """One thing that the referee saw; `gate` counts from 0 over all laps."""

    kind: CourseEventKind
    gate: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseStatus:
    """The score so far."""

    gates_passed: int
    gates_total: int
    state: CourseState
