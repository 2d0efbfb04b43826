"""What a course is made of, and how wide its camera sees: gates, colours, pictures on surfaces."""

from dataclasses import dataclass

from sitl.errors import UsageError
from sitl.records.gate import STANDARD_SHAPE, GateShape
from sitl.records.motion import Vector3

FIELD_OF_VIEW_DEG = 90.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenery:
    """The defaults are the course of this simulator; all else is a world of one's own.

    Colours are linear RGB from 0 to 1; each day draws one between low and high. A picture is the
    path of a file that OpenCV reads; each day draws one of them, and without any the gates are
    plain and the ground is of seeded noise.
    """

    gate: GateShape = STANDARD_SHAPE
    field_of_view_deg: float = FIELD_OF_VIEW_DEG  # of the square image, either way
    gate_colour_low: Vector3 = (0.75, 0.15, 0.0)
    gate_colour_high: Vector3 = (1.0, 0.55, 0.2)
    gate_pictures: tuple[str, ...] = ()  # around each bar, coloured by the gate's colour
    ground_pictures: tuple[str, ...] = ()  # light and dark of them, in the ground's colours

    def __post_init__(self) -> None:
        """Check what the ranges alone do not; raises UsageError."""
        pairs = zip(self.gate_colour_low, self.gate_colour_high, strict=True)
        if not all(0.0 <= low <= high <= 1.0 for low, high in pairs):
            raise UsageError(
                f"gate_colour_low {list(self.gate_colour_low)} and gate_colour_high "
                f"{list(self.gate_colour_high)}: must lie in order from 0 to 1"
            )


PLAIN = Scenery()
