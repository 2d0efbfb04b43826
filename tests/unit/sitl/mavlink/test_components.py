"""The camera and the referee as components of their own."""

from typing import Any

import pytest

from sitl.mavlink.components.camera_component import CameraComponent, CameraFacts
from sitl.mavlink.components.referee_component import RefereeComponent, flies_a_mission
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.course import CourseEvent, CourseEventKind, CourseState, CourseStatus
from sitl.records.images import ImageStamp
from sitl.records.missions import MissionProgress, MissionState
from sitl.records.modes import Mode
from tests.unit.sitl.mavlink.fakes import FakeOutlet, FakeVehicle, make_request

FACTS = CameraFacts(
    stream_uri="http://127.0.0.1:8090/stream",
    width_px=64,
    height_px=48,
    field_of_view_deg=90,
    rate_hz=20.0,
)
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3


def command(number: int, param1: float = 0.0) -> Any:
    return mavlink.MAVLink_command_long_message(1, 100, number, 0, param1, *[0.0] * 6)


def ask_camera(number: int, param1: float = 0.0) -> list[Any]:
    outlet = FakeOutlet()
    CameraComponent(FACTS).handle(command(number, param1), make_request(outlet), 2_000_000)
    return outlet.messages


def test_the_camera_says_where_its_stream_is() -> None:
    stream, acknowledgement = ask_camera(512, 269)
    assert stream.uri == "http://127.0.0.1:8090/stream"
    assert (stream.stream_id, stream.count, stream.flags) == (1, 1, 1)
    assert (stream.resolution_h, stream.resolution_v) == (64, 48)
    assert (stream.framerate, stream.hfov) == (20.0, 90)
    assert (acknowledgement.command, acknowledgement.result) == (512, ACCEPTED)


def test_the_camera_says_that_it_has_a_stream() -> None:
    information, _ = ask_camera(512, 259)
    assert information.flags == mavlink.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM
    assert information.time_boot_ms == 2000
    assert bytes(information.vendor_name).rstrip(b"\0") == b"flightstack"


@pytest.mark.parametrize(
    ("number", "name"), [(521, "CAMERA_INFORMATION"), (2504, "VIDEO_STREAM_INFORMATION")]
)
def test_older_ways_to_ask_are_understood(number: int, name: str) -> None:
    message, acknowledgement = ask_camera(number)
    assert message.get_type() == name
    assert (acknowledgement.command, acknowledgement.result) == (number, ACCEPTED)


@pytest.mark.parametrize("message_id", [261, 262, 9999, float("nan")])
def test_what_a_fixed_camera_has_not_is_denied(message_id: float) -> None:
    assert [m.result for m in ask_camera(512, message_id)] == [DENIED]


def test_the_camera_does_not_fly() -> None:
    assert [m.result for m in ask_camera(400, 1)] == [UNSUPPORTED]


def test_a_trigger_has_the_stamp_and_number_of_its_image() -> None:
    trigger = CameraComponent(FACTS).trigger(ImageStamp(152_000, 3))
    assert (trigger.time_usec, trigger.seq) == (152_000, 3)


def event(kind: CourseEventKind, gate: int, text: str) -> CourseEvent:
    return CourseEvent(kind=kind, gate=gate, text=text)


def test_a_passed_gate_is_an_item_reached_a_text_and_a_new_score() -> None:
    vehicle = FakeVehicle()
    referee = RefereeComponent(vehicle)
    assert referee.events() == []
    vehicle.course = CourseStatus(gates_passed=3, gates_total=8, state=CourseState.ACTIVE)
    vehicle.events = [event(CourseEventKind.PASSED, 2, "Passed gate 3 of 8")]
    reached, text, score = referee.events()
    assert (reached.get_type(), reached.seq) == ("MISSION_ITEM_REACHED", 2)
    assert (text.text, text.severity) == ("Passed gate 3 of 8", 6)
    assert (score.seq, score.total, score.mission_state) == (3, 8, 3)


@pytest.mark.parametrize(("mode", "speaks"), [(Mode.MISSION, False), (Mode.OFFBOARD, True)])
def test_nobody_takes_the_score_for_the_progress_of_a_mission(mode: Mode, speaks: bool) -> None:  # noqa: FBT001
    vehicle = FakeVehicle()
    referee = RefereeComponent(vehicle, lambda: flies_a_mission(vehicle.autopilot))
    assert [m.get_type() for m in referee.scores()] == ["MISSION_CURRENT"]
    vehicle.autopilot.missions.progress = MissionProgress(0, 3, MissionState.ACTIVE, speaks)
    vehicle.autopilot.change(intended_mode=mode)
    vehicle.events = [event(CourseEventKind.PASSED, 2, "Passed gate 3 of 8")]
    scored = ["MISSION_ITEM_REACHED", "STATUSTEXT", "MISSION_CURRENT"]
    assert [m.get_type() for m in referee.events()] == (scored if speaks else ["STATUSTEXT"])
    assert len(referee.scores()) == int(speaks)


@pytest.mark.parametrize(
    ("kind", "state", "severity", "mission_state"),
    [
        (CourseEventKind.FINISHED, CourseState.FINISHED, 5, 5),
        (CourseEventKind.MISSED, CourseState.FAILED, 4, 4),
        (CourseEventKind.COLLISION, CourseState.FAILED, 4, 4),
    ],
)
def test_the_end_of_a_course(
    kind: CourseEventKind, state: CourseState, severity: int, mission_state: int
) -> None:
    vehicle = FakeVehicle()
    vehicle.course = CourseStatus(gates_passed=8, gates_total=8, state=state)
    vehicle.events = [event(kind, 7, "the end")]
    text, score = RefereeComponent(vehicle).events()
    assert (text.text, text.severity) == ("the end", severity)
    assert score.mission_state == mission_state


@pytest.mark.parametrize(("message_id", "results"), [(42, [None, ACCEPTED]), (30, [DENIED])])
def test_the_score_can_be_asked_for(message_id: int, results: list[int | None]) -> None:
    outlet = FakeOutlet()
    RefereeComponent(FakeVehicle()).handle(command(512, message_id), make_request(outlet))
    assert [getattr(m, "result", None) for m in outlet.messages] == results
    RefereeComponent(FakeVehicle()).handle(command(400, 1), make_request(outlet))
    assert outlet.messages[-1].result == UNSUPPORTED


def ask_referee(vehicle: FakeVehicle, message: Any) -> list[Any]:
    outlet = FakeOutlet()
    referee = RefereeComponent(vehicle)
    is_list = message.get_type() == "MISSION_REQUEST_LIST"
    (referee.answer_list if is_list else referee.answer_item)(message, make_request(outlet))
    return outlet.messages


@pytest.mark.parametrize(("mission_type", "count"), [(0, 8), (1, 0), (2, 0), (255, 0)])
def test_the_gates_are_a_mission_of_the_referee(mission_type: int, count: int) -> None:
    asked = mavlink.MAVLink_mission_request_list_message(1, 25, mission_type)
    (answer,) = ask_referee(FakeVehicle(), asked)
    assert (answer.get_type(), answer.count, answer.mission_type) == (
        "MISSION_COUNT",
        count,
        mission_type,
    )
    assert (answer.target_system, answer.target_component) == (255, 190)


@pytest.mark.parametrize("kind", ["mission_request_int", "mission_request"])
def test_a_gate_is_an_item_in_the_local_frame(kind: str) -> None:
    vehicle = FakeVehicle()
    vehicle.course = CourseStatus(gates_passed=10, gates_total=16, state=CourseState.ACTIVE)
    ask = getattr(mavlink, f"MAVLink_{kind}_message")
    items = [ask_referee(vehicle, ask(1, 25, number))[0] for number in range(8)]
    assert {item.get_type() for item in items} == {"MISSION_ITEM_INT"}
    assert [item.current for item in items] == [0, 0, 1, 0, 0, 0, 0, 0]
    item = items[2]
    assert (item.seq, item.frame, item.command) == (2, mavlink.MAV_FRAME_LOCAL_NED, 16)
    assert (item.x, item.y, item.z) == (27_000, 20_001, -5.0)
    assert item.param2 == pytest.approx(0.6)
    assert item.param4 == pytest.approx(28.6479, abs=1e-4)


def test_after_the_course_no_gate_is_due() -> None:
    vehicle = FakeVehicle()
    vehicle.course = CourseStatus(gates_passed=8, gates_total=8, state=CourseState.FINISHED)
    (item,) = ask_referee(vehicle, mavlink.MAVLink_mission_request_int_message(1, 25, 0))
    assert item.current == 0


@pytest.mark.parametrize(("number", "mission_type"), [(8, 0), (65535, 0), (0, 1)])
def test_a_gate_that_is_not_there_is_silence(number: int, mission_type: int) -> None:
    asked = mavlink.MAVLink_mission_request_int_message(1, 25, number, mission_type)
    assert ask_referee(FakeVehicle(), asked) == []
