"""Judge the flight: which gate was passed, which missed, and when the course is over.

The vehicle has to pass gate after gate, in order and in the right direction. Crossing the plane
of the gate that is due inside its opening passes it; crossing near but outside it, or backwards,
misses it; touching a gate is a collision. A miss or a collision fails the course for good.

    active --last gate passed--> finished
       `--miss, collision-----> failed
"""

import math

from sitl.records.course import CourseEvent, CourseEventKind, CourseState, CourseStatus, Gate
from sitl.records.motion import Vector3

NEARBY_M = (
    4.0  # a crossing of the gate's plane farther from its centre is another part of the circle
)


class Referee:
    """Follow a vehicle around a course, tick by tick."""

    def __init__(self, gates: tuple[Gate, ...], laps: int) -> None:
        self._gates = gates
        self._total = len(gates) * laps
        self._passed = 0
        self._state = CourseState.ACTIVE

    @property
    def status(self) -> CourseStatus:
        """The score so far."""
        return CourseStatus(gates_passed=self._passed, gates_total=self._total, state=self._state)

    def update(self, previous: Vector3, current: Vector3, *, contact: bool) -> list[CourseEvent]:
        """Judge one tick's movement from `previous` to `current` (m, NED)."""
        if self._state is not CourseState.ACTIVE:
            return []
        if contact:
            return [
                self._fail(CourseEventKind.COLLISION, f"Collision with gate {self._passed + 1}")
            ]
        gate = self._gates[self._passed % len(self._gates)]
        crossing = _crossing(gate, previous, current)
        if crossing is None:
            return []
        right, down, forwards = crossing
        if not gate.shape.is_open_at(right, down):
            where = f"{abs(right):.1f} m {'right' if right > 0 else 'left'}, {abs(down):.1f} m " + (
                "low" if down > 0 else "high"
            )
            return [self._fail(CourseEventKind.MISSED, f"Missed gate {self._passed + 1}: {where}")]
        if not forwards:
            text = f"Missed gate {self._passed + 1}: passed backwards"
            return [self._fail(CourseEventKind.MISSED, text)]
        return self._pass()

    def _pass(self) -> list[CourseEvent]:
        gate = self._passed
        self._passed += 1
        text = f"Passed gate {self._passed} of {self._total}"
        events = [CourseEvent(kind=CourseEventKind.PASSED, gate=gate, text=text)]
        if self._passed == self._total:
            self._state = CourseState.FINISHED
            events.append(
                CourseEvent(kind=CourseEventKind.FINISHED, gate=gate, text="Course finished")
            )
        return events

    def _fail(self, kind: CourseEventKind, text: str) -> CourseEvent:
        self._state = CourseState.FAILED
        return CourseEvent(kind=kind, gate=self._passed, text=text)


def _crossing(gate: Gate, previous: Vector3, current: Vector3) -> tuple[float, float, bool] | None:
    """Where the movement crosses the gate's plane near it: (right, down) m and whether forwards."""
    axis_n, axis_e = math.cos(gate.yaw_rad), math.sin(gate.yaw_rad)
    before = _along(gate, previous, axis_n, axis_e)
    after = _along(gate, current, axis_n, axis_e)
    if (before < 0.0) == (after < 0.0):
        return None
    share = before / (before - after)
    north, east, down = (p + share * (c - p) for p, c in zip(previous, current, strict=True))
    north -= gate.centre_ned[0]
    east -= gate.centre_ned[1]
    down -= gate.centre_ned[2]
    right = -axis_e * north + axis_n * east
    if math.hypot(right, down) > NEARBY_M:
        return None
    return right, down, after >= 0.0


def _along(gate: Gate, point: Vector3, axis_n: float, axis_e: float) -> float:
    return axis_n * (point[0] - gate.centre_ned[0]) + axis_e * (point[1] - gate.centre_ned[1])
