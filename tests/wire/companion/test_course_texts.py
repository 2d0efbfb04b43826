"""What the referee says is what the companion understands."""

from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import common

from flightstack.clock import VehicleClock
from flightstack.mavlink.telemetry import CourseFailure, TelemetryReceiver
from sitl.mavlink.wire.texts import statustexts
from sitl.records.course import CourseEvent, Gate
from sitl.world.referee import Referee

REFEREE = 25
GATES = tuple(Gate(index=i, centre_ned=(5.0 + 6.0 * i, 0.0, -3.0), yaw_rad=0.0) for i in range(2))


def collide(referee: Referee) -> list[CourseEvent]:
    return referee.update((4.8, 0.0, -3.0), (4.9, 0.0, -3.0), contact=True)


def fly_past(referee: Referee) -> list[CourseEvent]:
    return referee.update((4.9, 0.0, -1.0), (5.1, 0.0, -1.0), contact=False)


@pytest.mark.parametrize(
    ("fly", "failure"),
    [(collide, CourseFailure.COLLISION), (fly_past, CourseFailure.MISSED_GATE)],
)
def test_companion_understands_how_the_course_failed(
    fly: Callable[[Referee], list[CourseEvent]], failure: CourseFailure
) -> None:
    receiver = TelemetryReceiver(VehicleClock())
    codec = common.MAVLink(None, srcSystem=1, srcComponent=REFEREE)
    for event in fly(Referee(GATES, laps=1)):
        for text in statustexts(4, event.text, text_id=0):
            receiver.update(codec.decode(bytearray(text.pack(codec))))
    assert receiver.latest.course.failure is failure
