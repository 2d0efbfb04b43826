"""What a vehicle on the ground answers: acknowledgements, texts and silences of a running PX4."""

from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.vehicle_process import (
    GCS,
    OTHER_COMPONENT,
    OTHER_SYSTEM,
    Client,
    Vehicle,
    command_long,
    is_acknowledgement,
    is_from,
    is_text,
)

pytestmark = pytest.mark.flight
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = 0, 1, 2, 3, 4
NAN = float("nan")
OFFBOARD, HOLD = 6, 4
PROTOCOL_VERSION = 300  # which pymavlink leaves out


@pytest.fixture(scope="module")
def vehicle() -> Iterator[Vehicle]:
    with Vehicle("-q", "--speed-factor=4") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello(GCS)
        vehicle.gcs.wait_for(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.system_status == mavlink.MAV_STATE_STANDBY
        )
        yield vehicle


@pytest.fixture
def client(vehicle: Vehicle) -> Iterator[Client]:
    """Hand out the ground station's end, with the vehicle disarmed and in HOLD afterwards."""
    vehicle.gcs.forget()
    vehicle.gcs.ask(mavlink.MAVLink_heartbeat_message(GCS, 8, 0, 0, 4, 3))  # it may be regained
    yield vehicle.gcs
    vehicle.gcs.command(176, 1, 4, 3)
    vehicle.gcs.command(400, 0, 21196)
    vehicle.gcs.wait_for(is_acknowledgement(400))


def answers(
    client: Client, command: int, *params: float, target: tuple[int, int] = (1, 1)
) -> list[int]:
    """All acknowledgements of a command."""
    heard = client.ask(command_long(command, *params, target=target))
    return [m.result for m in heard if is_acknowledgement(command)(m)]


def id_of(message: Any) -> int:
    """The message's number in its frame, whether pymavlink knows it or not."""
    return int.from_bytes(message.get_msgbuf()[7:10], "little")


def said(heard: list[Any]) -> str:
    """All texts in a row."""
    return "".join(m.text for m in heard if m.get_type() == "STATUSTEXT")


@pytest.mark.parametrize(
    ("command", "params", "results"),
    [
        (512, [148], [ACCEPTED]),
        (512, [242], [ACCEPTED]),
        (512, [300], [ACCEPTED]),
        (512, [435], [ACCEPTED]),
        (512, [9999], [DENIED]),
        (512, [47], [DENIED]),
        (512, [259], [DENIED]),
        (511, [30, 20000], [ACCEPTED]),
        (511, [9999, 20000], [FAILED]),
        (510, [30], [ACCEPTED]),
        (519, [], [ACCEPTED]),
        (520, [], [ACCEPTED]),
        (31999, [], [UNSUPPORTED]),
        (2000, [], [UNSUPPORTED]),
        (2520, [], [UNSUPPORTED]),
        (176, [1, 4, 3], [ACCEPTED, ACCEPTED]),
        (176, [1, 6, 0], [ACCEPTED, ACCEPTED]),
        (176, [1, 99, 0], [ACCEPTED, ACCEPTED]),
        (176, [0, 6, 0], [ACCEPTED, ACCEPTED]),
        (400, [0], [ACCEPTED]),
        (400, [3], []),
        (246, [99], [DENIED]),
        (22, [NAN] * 7, [ACCEPTED]),
        (22, [NAN] * 4 + [2147483648.0, NAN, NAN], [DENIED]),
    ],
)
def test_acknowledgements(
    client: Client, command: int, params: list[float], results: list[int]
) -> None:
    assert answers(client, command, *params) == results


@pytest.mark.parametrize(
    ("target", "command", "answered"),
    [
        ((1, 0), 400, 1),
        ((2, 1), 400, 0),
        ((1, 99), 400, 0),
        ((0, 0), 400, 0),
        ((0, 0), 520, 1),
        ((1, 99), 519, 1),
    ],
)
def test_who_answers(client: Client, target: tuple[int, int], command: int, answered: int) -> None:
    assert answers(client, command, 0, target=target) == [ACCEPTED] * answered


def test_an_acknowledgement_names_whoever_asked(client: Client) -> None:
    client.command(512, 148)
    version = client.wait_for("AUTOPILOT_VERSION")
    assert version.flight_sw_version >= 0x010F00FF
    answer = client.wait_for(is_acknowledgement(512))
    asked = (answer.target_system, answer.target_component)
    assert asked == (OTHER_SYSTEM, OTHER_COMPONENT)
    assert (answer.progress, answer.result_param2) == (0, 0)


@pytest.mark.parametrize("is_int", [False, True], ids=["COMMAND_LONG", "COMMAND_INT"])
@pytest.mark.parametrize("message_id", [148, 242, PROTOCOL_VERSION, 435])
def test_what_is_asked_for_comes_before_the_answer(
    client: Client, message_id: int, *, is_int: bool
) -> None:
    message = command_long(512, message_id)
    if is_int:
        numbers = (512, 0, 0, message_id, *[0.0] * 3, 0, 0, 0.0)
        message = mavlink.MAVLink_command_int_message(1, 1, 0, *numbers)
    ids = [id_of(m) for m in client.ask(message)]
    assert message_id in ids[: ids.index(mavlink.MAVLINK_MSG_ID_COMMAND_ACK)]


def test_the_protocol_version_is_200(client: Client) -> None:
    heard = client.ask(command_long(519))
    (shown,) = [m for m in heard if id_of(m) == PROTOCOL_VERSION]
    assert int.from_bytes(shown.get_msgbuf()[10:12], "little") == 200  # after MAVLink 2's header


@pytest.mark.parametrize("params", [(1, 99, 0), (0, 6, 0)], ids=["mode 99", "without bit 0"])
def test_a_mode_that_there_is_not_changes_nothing(
    client: Client, params: tuple[float, ...]
) -> None:
    assert said(client.ask(command_long(176, *params))) == ""
    assert client.wait_for(is_from(1, "HEARTBEAT")).custom_mode == 0x03040000


def test_take_off_disarmed_is_accepted_and_waits_for_arming(client: Client) -> None:
    assert answers(client, 22, *[NAN] * 7) == [ACCEPTED]
    beat = client.wait_for(is_from(1, "HEARTBEAT"))
    assert (beat.custom_mode, beat.base_mode) == (0x02040000, 29)


def test_what_is_so_already_is_accepted_without_a_word(client: Client) -> None:
    for wanted in (0, 1):
        answers(client, 400, wanted)
        heard = client.ask(command_long(400, wanted))
        assert [m.result for m in heard if is_acknowledgement(400)(m)] == [ACCEPTED]
        assert said(heard) == ""


def test_texts_are_numbered_one_by_one(client: Client) -> None:
    heard = client.ask(command_long(400, 1)) + client.ask(command_long(400, 0))
    ids = [m.id for m in heard if m.get_type() == "STATUSTEXT"]
    assert len(ids) >= 2
    assert ids == list(range(ids[0], ids[0] + len(ids)))


def test_a_ping_to_the_vehicle_itself_is_not_answered(client: Client) -> None:
    heard = client.ask(mavlink.MAVLink_ping_message(0, 77, 1, 1))
    assert 77 not in {m.seq for m in heard if m.get_type() == "PING"}


def test_arming_and_disarming_are_told(client: Client) -> None:
    client.command(400, 1)
    assert client.wait_for(is_acknowledgement(400)).result == ACCEPTED
    assert client.wait_for(is_text("Armed")).text == "Armed by external command\t"
    beat = client.wait_for(is_from(1, "HEARTBEAT"))
    while not beat.base_mode & 128:
        beat = client.wait_for(is_from(1, "HEARTBEAT"))
    assert (beat.base_mode, beat.system_status) == (157, 4)
    client.command(400, 0)
    assert client.wait_for(is_acknowledgement(400)).result == ACCEPTED
    assert client.wait_for(is_text("Disarmed")).text == "Disarmed by external command\t"


def test_arming_is_refused_in_offboard_without_setpoints(client: Client) -> None:
    assert answers(client, 176, 1, OFFBOARD) == [ACCEPTED, ACCEPTED]

    def shown(message: Any) -> bool:
        return is_from(1, "HEARTBEAT")(message) and message.custom_mode == 0x00060000

    beat = client.wait_for(shown)
    assert (beat.base_mode, beat.system_status) == (1, 0)
    client.command(400, 1)
    assert client.wait_for(is_acknowledgement(400)).result == TEMPORARILY_REJECTED
    text = client.wait_for(is_text("Arming denied"))
    assert (text.severity, text.chunk_seq) == (2, 0)
    rest = client.wait_for("STATUSTEXT")
    assert (rest.id, rest.chunk_seq) == (text.id, 1)
    assert text.text + rest.text == "Arming denied: Resolve system health failures first\t"


def test_an_unsupported_arming_parameter_is_told_but_not_acknowledged(client: Client) -> None:
    heard = client.ask(command_long(400, 3))
    assert said(heard) == "Unsupported ARM_DISARM param: 3.000\t"
    assert not [m for m in heard if is_acknowledgement(400)(m)]


def test_set_mode_is_acknowledged_once(client: Client) -> None:
    heard = client.ask(mavlink.MAVLink_set_mode_message(1, 1, 4 << 16 | 3 << 24))
    assert [m.result for m in heard if is_acknowledgement(176)(m)] == [ACCEPTED]


@pytest.mark.parametrize(
    ("frame", "mask", "beginning", "whole"),
    [
        (12, 0x5C7, "SET_POSITION_TARGET_LOCAL_NED coordinate frame 12 ", False),
        (8, 0x0DFF, "SET_POSITION", True),
        (8, 0x5CF, "SET_POSITION", True),
    ],
)
def test_refused_setpoints_are_told(
    client: Client, frame: int, mask: int, beginning: str, *, whole: bool
) -> None:
    client.send(
        mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *[0.0] * 11)
    )
    text = client.wait_for(is_text(beginning))
    if whole:
        assert text.text == "SET_POSITION_TARGET_LOCAL_NED invalid\t"
    else:
        assert client.wait_for(is_text("unsupported")).id == text.id


def test_texts_come_only_to_ground_stations(vehicle: Vehicle, client: Client) -> None:
    vehicle.api.say_hello(18)
    vehicle.api.forget()
    assert "Armed" in said(client.ask(command_long(400, 1)))
    assert said(vehicle.api.ask(command_long(512, 148))) == ""


def test_time_is_told_to_whoever_asks(client: Client) -> None:
    client.send(mavlink.MAVLink_timesync_message(0, 123456789))
    answer = client.wait_for(lambda m: m.get_type() == "TIMESYNC" and m.tc1 != 0)
    assert answer.ts1 == 123456789
    boot_ms = client.wait_for("ATTITUDE").time_boot_ms
    assert 0 <= boot_ms - answer.tc1 / 1e6 < 1000
    client.send(mavlink.MAVLink_ping_message(77, 5, 0, 0))
    pong = client.wait_for(lambda m: m.get_type() == "PING" and m.target_system != 0)
    assert (pong.time_usec, pong.seq) == (77, 5)
    assert (pong.target_system, pong.target_component) == (OTHER_SYSTEM, OTHER_COMPONENT)


def test_there_is_no_mission_at_first(client: Client) -> None:
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
    assert client.wait_for("MISSION_COUNT").count == 0


def test_camera_and_referee_answer_for_themselves(client: Client) -> None:
    client.command(512, 269, target=(1, 100))
    stream = client.wait_for("VIDEO_STREAM_INFORMATION")
    assert stream.uri.startswith("http://127.0.0.1:")
    assert stream.get_srcComponent() == 100
    client.command(512, 42, target=(1, 25))
    score = client.wait_for(is_from(25, "MISSION_CURRENT"))
    assert (score.seq, score.total, score.mission_state) == (0, 8, 3)


def test_heartbeats_are_forwarded_between_the_links(vehicle: Vehicle, client: Client) -> None:
    vehicle.api.say_hello(18)
    forwarded = client.wait_for(lambda m: m.get_srcSystem() == OTHER_SYSTEM)
    assert (forwarded.get_type(), forwarded.type) == ("HEARTBEAT", 18)
