import itertools

import pytest

from sitl.records.course import CourseEvent, CourseEventKind, CourseState, Direction, Gate
from sitl.world.referee import Referee
from sitl.world.track import make_track

GATE = Gate(index=0, centre_ned=(5.0, 0.0, -3.0), yaw_rad=0.0)
BEFORE, BEHIND = (4.9, 0.0, -3.0), (5.1, 0.0, -3.0)


def moved(
    point: tuple[float, float, float], east: float = 0.0, down: float = 0.0
) -> tuple[float, float, float]:
    return (point[0], point[1] + east, point[2] + down)


def kinds(events: list[CourseEvent]) -> list[CourseEventKind]:
    return [event.kind for event in events]


def test_crossing_inside_the_opening_passes() -> None:
    referee = Referee((GATE,), laps=2)
    assert kinds(referee.update(BEFORE, BEHIND, contact=False)) == [CourseEventKind.PASSED]
    assert referee.status.gates_passed == 1
    assert referee.status.gates_total == 2


@pytest.mark.parametrize(
    ("east", "down", "word"),
    [(0.7, 0, "right"), (-0.7, 0, "left"), (0, 0.7, "low"), (0, -1, "high")],
)
def test_crossing_beside_the_opening_misses_and_says_where(
    east: float, down: float, word: str
) -> None:
    referee = Referee((GATE,), laps=1)
    start, end = moved(BEFORE, east, down), moved(BEHIND, east, down)
    (event,) = referee.update(start, end, contact=False)
    assert event.kind is CourseEventKind.MISSED
    assert word in event.text
    assert referee.status.state is CourseState.FAILED


def test_the_edge_of_the_opening_is_60_cm_from_its_centre() -> None:
    inside, outside = Referee((GATE,), laps=1), Referee((GATE,), laps=1)
    inside.update(moved(BEFORE, 0.59), moved(BEHIND, 0.59), contact=False)
    outside.update(moved(BEFORE, 0.61), moved(BEHIND, 0.61), contact=False)
    assert inside.status.state is CourseState.FINISHED
    assert outside.status.state is CourseState.FAILED


def test_passing_backwards_misses() -> None:
    (event,) = Referee((GATE,), laps=1).update(BEHIND, BEFORE, contact=False)
    assert event.kind is CourseEventKind.MISSED
    assert "backwards" in event.text


def test_crossing_the_plane_far_away_is_another_part_of_the_circle() -> None:
    referee = Referee((GATE,), laps=1)
    assert referee.update(moved(BEFORE, 16.0), moved(BEHIND, 16.0), contact=False) == []
    assert referee.status.state is CourseState.ACTIVE


def test_only_the_gate_that_is_due_counts() -> None:
    second = Gate(index=1, centre_ned=(10.0, 0.0, -3.0), yaw_rad=0.0)
    referee = Referee((GATE, second), laps=1)
    assert referee.update((9.9, 0.0, -3.0), (10.1, 0.0, -3.0), contact=False) == []
    referee.update(BEFORE, BEHIND, contact=False)
    events = referee.update((9.9, 0.0, -3.0), (10.1, 0.0, -3.0), contact=False)
    assert kinds(events) == [CourseEventKind.PASSED, CourseEventKind.FINISHED]


def test_a_collision_fails_the_course_for_good() -> None:
    referee = Referee((GATE,), laps=1)
    assert kinds(referee.update(BEFORE, BEFORE, contact=True)) == [CourseEventKind.COLLISION]
    assert referee.update(BEFORE, BEHIND, contact=False) == []
    assert referee.status.gates_passed == 0


@pytest.mark.parametrize("direction", ["cw", "ccw"])
def test_straight_flight_from_gate_to_gate_passes_every_one(direction: Direction) -> None:
    gates = make_track(1, direction=direction).gates
    referee = Referee(gates, laps=4)
    points = [(0.0, 0.0, -3.0)] + [gate.centre_ned for gate in gates] * 4
    for start, end in itertools.pairwise(points):
        x, y, z = (e + 0.02 * (e - s) for s, e in zip(start, end, strict=True))
        referee.update(start, (x, y, z), contact=False)
    assert referee.status.gates_passed == 32
    assert referee.status.state is CourseState.FINISHED
