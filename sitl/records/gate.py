"""The shape of a gate: a frame of bars around an opening, square or round.

Gate frame: x along the passing axis, y to the right, z down; origin in the opening's centre.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from sitl.errors import UsageError
from sitl.records.motion import Quaternion, Vector3

GATE_INNER_M = 1.2  # side of the opening; Bonatti et al. 2020, spawn scale 0.75
GATE_OUTER_M = 1.6  # side of the frame
DEPTH_M = 0.15  # along the passing axis
RING_BARS = 12  # of a round frame

Outline = Literal["square", "circle"]


class Bar(NamedTuple):
    """One bar of a frame: a box, in the gate's frame."""

    centre: Vector3  # m
    half_extents: Vector3  # m: along the passing axis, along the bar, across it
    q: Quaternion  # w, x, y, z: from the box's axes to the gate's


@dataclass(frozen=True, slots=True, kw_only=True)
class GateShape:
    """What a gate is; the sides of a square, or the diameters of a circle."""

    outline: Outline = "square"
    inner_m: float = GATE_INNER_M
    outer_m: float = GATE_OUTER_M
    depth_m: float = DEPTH_M

    def __post_init__(self) -> None:
        """Check what the ranges alone do not; raises UsageError."""
        if not self.inner_m < self.outer_m:
            raise UsageError(
                f"outer_m: must be above inner_m, {self.inner_m:g}, got {self.outer_m:g}"
            )

    def is_open_at(self, right_m: float, down_m: float) -> bool:
        """Whether a point of the gate's plane lies in its opening."""
        if self.outline == "circle":
            return math.hypot(right_m, down_m) < self.inner_m / 2.0
        return max(abs(right_m), abs(down_m)) < self.inner_m / 2.0

    def bars(self) -> tuple[Bar, ...]:
        """Say what its frame is made of."""
        return _ring(self) if self.outline == "circle" else _square(self)


STANDARD_SHAPE = GateShape()


def _square(shape: GateShape) -> tuple[Bar, ...]:
    level = (1.0, 0.0, 0.0, 0.0)
    bar_m = (shape.outer_m - shape.inner_m) / 2.0
    deep, half_bar, centre = shape.depth_m / 2.0, bar_m / 2.0, (shape.inner_m + bar_m) / 2.0
    beam = (deep, shape.outer_m / 2.0, half_bar)
    post = (deep, half_bar, shape.inner_m / 2.0)
    return (
        Bar((0.0, 0.0, -centre), beam, level),
        Bar((0.0, 0.0, centre), beam, level),
        Bar((0.0, centre, 0.0), post, level),
        Bar((0.0, -centre, 0.0), post, level),
    )


def _ring(shape: GateShape) -> tuple[Bar, ...]:
    """Lay bars around a circle, each along its tangent; their inner faces touch the opening."""
    middle_m, half_bar = (
        (shape.inner_m + shape.outer_m) / 4.0,
        (shape.outer_m - shape.inner_m) / 4.0,
    )
    half_length = shape.outer_m / 2.0 * math.tan(math.pi / RING_BARS)
    bars = []
    for number in range(RING_BARS):
        angle = 2.0 * math.pi * number / RING_BARS  # from the top, to the right
        bars.append(
            Bar(
                (0.0, middle_m * math.sin(angle), -middle_m * math.cos(angle)),
                (shape.depth_m / 2.0, half_length, half_bar),
                (math.cos(angle / 2.0), math.sin(angle / 2.0), 0.0, 0.0),
            )
        )
    return tuple(bars)
