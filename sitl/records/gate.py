"""The shape of a gate: a square frame of four bars around a square opening.

Gate frame: x along the passing axis, y to the right, z down; origin in the opening's centre.
"""

from sitl.records.motion import Vector3

GATE_INNER_M = 1.2  # side of the opening; Bonatti et al. 2020, spawn scale 0.75
GATE_OUTER_M = 1.6  # side of the frame
DEPTH_M = 0.15  # along the passing axis
BAR_M = (GATE_OUTER_M - GATE_INNER_M) / 2.0

_HALF_DEPTH = DEPTH_M / 2.0
_HALF_BAR = BAR_M / 2.0
_BAR_CENTRE = (GATE_INNER_M + BAR_M) / 2.0

BAR_HALF_EXTENTS: tuple[Vector3, ...] = (
    (_HALF_DEPTH, GATE_OUTER_M / 2.0, _HALF_BAR),
    (_HALF_DEPTH, GATE_OUTER_M / 2.0, _HALF_BAR),
    (_HALF_DEPTH, _HALF_BAR, GATE_INNER_M / 2.0),
    (_HALF_DEPTH, _HALF_BAR, GATE_INNER_M / 2.0),
)
BAR_CENTRES: tuple[Vector3, ...] = (
    (0.0, 0.0, -_BAR_CENTRE),
    (0.0, 0.0, _BAR_CENTRE),
    (0.0, _BAR_CENTRE, 0.0),
    (0.0, -_BAR_CENTRE, 0.0),
)
