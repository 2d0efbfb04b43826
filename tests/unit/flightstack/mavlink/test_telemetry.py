"""Messages fold into one view of the vehicle."""

from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common

from flightstack.mavlink.telemetry import (
    CourseFailure,
    LandedState,
    StatusText,
    Telemetry,
    TelemetryReceiver,
)
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

REFEREE, CAMERA = 25, 100


class Ear:
    def __init__(self, folder: Path) -> None:
        self.made = MadeLink(folder)
        self.receiver = TelemetryReceiver(self.made.clock)
        self.hear(heartbeat())

    def hear(self, message: Any, component: int = 1) -> Telemetry:
        self.made.say(message, component=component)
        for decoded in self.made.link.drain():
            self.receiver.update(decoded)
        return self.receiver.latest


@pytest.fixture
def ear(tmp_path: Path) -> Ear:
    return Ear(tmp_path)


def current(seq: int, total: int, state: int) -> Any:
    return common.MAVLink_mission_current_message(seq, total, state)


def statustext(text: str, number: int = 0, chunk: int = 0) -> Any:
    return common.MAVLink_statustext_message(4, text.encode(), number, chunk)


def test_mode_and_arming_come_from_the_heartbeat(ear: Ear) -> None:
    view = ear.hear(heartbeat(mode=0x00060000, base_mode=145, status=4))
    assert (view.custom_mode, view.armed, view.armable) == (0x00060000, True, False)
    assert ear.hear(heartbeat(status=3)).armable


def test_a_heartbeat_before_any_stamp_has_no_time(ear: Ear) -> None:
    assert ear.receiver.latest.heartbeat_us is None
    ear.made.clock.observe(4_000_000)
    assert ear.hear(heartbeat()).heartbeat_us == 4_000_000


def test_landed_state_keeps_its_beginning(ear: Ear) -> None:
    for stamp_us in (1_000_000, 2_000_000):
        ear.made.clock.observe(stamp_us)
        view = ear.hear(common.MAVLink_extended_sys_state_message(0, 2))
    assert (view.landed, view.landed_us) == (LandedState.IN_AIR, 1_000_000)


def test_home_and_motion_are_in_metres(ear: Ear) -> None:
    ear.hear(common.MAVLink_home_position_message(0, 0, 489_400, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))
    view = ear.hear(common.MAVLink_local_position_ned_message(1, 1, 2, -3, 4, 5, 6))
    assert view.home_altitude_amsl_m == pytest.approx(489.4)
    assert (view.position_ned, view.velocity_ned) == ((1, 2, -3), (4, 5, 6))


def test_the_camera_names_its_stream_and_announces_images(ear: Ear) -> None:
    uri = b"http://127.0.0.1:8090/stream"
    fields = (1, 1, 0, 1, 20.0, 64, 64, 0, 0, 90, b"camera", uri)
    ear.hear(common.MAVLink_video_stream_information_message(*fields), CAMERA)
    assert ear.receiver.stream_uri == uri.decode()
    trigger = common.MAVLink_camera_trigger_message(52_000, 1)
    assert ear.hear(trigger, CAMERA).trigger_us == 52_000


def test_the_referee_counts_gates(ear: Ear) -> None:
    view = ear.hear(current(0, 8, 3), REFEREE)
    assert (view.course.known, view.course.gates_passed, view.course.over) == (True, 0, False)
    assert (
        ear.hear(common.MAVLink_mission_item_reached_message(0), REFEREE).course.gates_passed == 1
    )
    assert ear.hear(current(5, 8, 3), REFEREE).course.gates_passed == 5
    assert ear.hear(current(8, 8, 5), REFEREE).course.finished


@pytest.mark.parametrize(
    ("text", "failure"),
    [
        ("Missed gate 4: 1.2 m left", CourseFailure.MISSED_GATE),
        ("Collision with gate 4", CourseFailure.COLLISION),
    ],
)
def test_the_referee_says_how_a_course_failed(ear: Ear, text: str, failure: CourseFailure) -> None:
    course = ear.hear(statustext(text), REFEREE).course
    assert (course.failed, course.failure) == (True, failure)
    assert ear.hear(current(3, 8, 4), REFEREE).course.failure is failure
    assert ear.receiver.drain_texts() == [StatusText(severity=4, text=text)]


def test_only_the_referee_judges(ear: Ear) -> None:
    assert not ear.hear(statustext("Missed gate 4")).course.over
    assert not ear.hear(current(0, 65535, 1), REFEREE).course.known


def test_long_texts_are_joined(ear: Ear) -> None:
    ear.hear(statustext("a" * 50, number=7))
    assert ear.receiver.drain_texts() == []
    ear.hear(statustext("end\t", number=7, chunk=1))
    assert ear.receiver.drain_texts() == [StatusText(severity=4, text="a" * 50 + "end")]
