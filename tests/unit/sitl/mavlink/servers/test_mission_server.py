"""The mission protocol, message by message, against vehicle time."""

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.mavlink.wire.dialect import mavlink
from sitl.records.missions import MissionResult, MissionState, PlanKind
from tests.unit.sitl.mavlink.servers.made_missions import (
    Client,
    acknowledgement,
    count,
    float_item,
    item,
    names,
    request_item,
    request_list,
)

KINDS = list(PlanKind)
RESULT = MissionResult


@pytest.fixture
def client() -> Client:
    return Client()


def answer(messages: list[Any]) -> tuple[str, int]:
    (message,) = messages
    return message.get_type(), message.type if hasattr(message, "type") else message.seq


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_uploaded_is_downloaded_again(client: Client, kind: PlanKind) -> None:
    items = [item(n, kind) for n in range(3)]
    assert client.upload(*items, kind=kind) == RESULT.ACCEPTED
    (answered,) = client.send(request_list(kind))
    assert (answered.count, answered.mission_type) == (3, kind)
    for sequence, sent in enumerate(items):
        (given_back,) = client.send(request_item(sequence, kind))
        expected = sent.to_dict() | {"target_system": 255, "target_component": 190}
        expected["current"] = int(kind is PlanKind.MISSION and sequence == 0)
        got = given_back.to_dict()
        assert math.isnan(got.pop("param4"))
        assert math.isnan(expected.pop("param4"))
        assert got == expected
    assert client.send(acknowledgement(kind=kind)) == []


@pytest.mark.parametrize("kind", KINDS)
def test_an_empty_list_has_count_0(client: Client, kind: PlanKind) -> None:
    (answered,) = client.send(request_list(kind), 42, 7)
    assert (answered.get_type(), answered.count, answered.mission_type) == (
        "MISSION_COUNT",
        0,
        kind,
    )
    assert (answered.target_system, answered.target_component) == (42, 7)


def test_the_float_messages_work_too(client: Client) -> None:
    assert client.upload(float_item(0), float_item(1)) == RESULT.ACCEPTED
    kept = client.missions.plan(PlanKind.MISSION)[1]
    assert (kept.frame, kept.x, kept.y) == (3, 473977428, 85455967)
    client.send(request_list())
    (given_back,) = client.send(mavlink.MAVLink_mission_request_message(1, 1, 0, 0))
    assert given_back.get_type() == "MISSION_ITEM"
    assert (given_back.frame, given_back.x) == (3, pytest.approx(47.3977428))


@pytest.mark.parametrize(
    ("message", "result"),
    [
        (count(0), RESULT.ACCEPTED),
        (count(1001), RESULT.NO_SPACE),
        (count(129, 1), RESULT.NO_SPACE),
        (count(33, 2), RESULT.NO_SPACE),
        (count(1, 77), RESULT.UNSUPPORTED),
        (request_list(77), RESULT.UNSUPPORTED),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 255), RESULT.ACCEPTED),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 0), RESULT.ACCEPTED),
        (mavlink.MAVLink_mission_clear_all_message(1, 1, 9), RESULT.UNSUPPORTED),
    ],
    ids=str,
)
def test_answers_out_of_nothing(client: Client, message: Any, result: MissionResult) -> None:
    assert answer(client.send(message)) == ("MISSION_ACK", result)


@pytest.mark.parametrize(
    ("message", "result"),
    [
        (item(0, param1=math.inf), RESULT.INVALID_PARAM1),
        (item(0, param4=-math.inf), RESULT.INVALID_PARAM4),
        (item(0, z=math.inf), RESULT.INVALID_PARAM7),
        (float_item(0, x=math.nan), RESULT.INVALID_PARAM5_X),
        (float_item(0, y=1e30), RESULT.INVALID_PARAM6_Y),
    ],
    ids=str,
)
def test_numbers_that_cannot_be_meant_end_the_upload(
    client: Client, message: Any, result: MissionResult
) -> None:
    client.upload(item(0))
    before = client.missions.plan(PlanKind.MISSION)
    client.send(count(2))
    assert answer(client.send(message)) == ("MISSION_ACK", result)
    assert client.missions.plan(PlanKind.MISSION) is before
    assert client.wait(1.0) == []


def test_what_the_vehicle_cannot_fly_ends_the_upload(client: Client) -> None:
    client.missions.item_result = RESULT.UNSUPPORTED
    client.send(count(2))
    assert answer(client.send(item(0))) == ("MISSION_ACK", 3)
    assert client.missions.plan(PlanKind.MISSION) == ()


def test_a_plan_that_the_vehicle_refuses_is_not_acknowledged_as_taken(client: Client) -> None:
    client.missions.plan_result = RESULT.DENIED
    assert client.upload(item(0)) == RESULT.DENIED


def test_an_item_is_asked_for_again_after_250_ms(client: Client) -> None:
    client.send(count(2))
    assert client.wait(0.248) == []
    assert answer(client.wait(0.008)) == ("MISSION_REQUEST_INT", 0)
    client.send(item(0))
    repeated = client.wait(1.0)
    assert [message.seq for message in repeated] == [1, 1, 1]


def test_an_upload_is_given_up_after_5_s_of_silence(client: Client) -> None:
    client.upload(item(0))
    client.send(count(2))
    client.send(item(0))
    client.wait(4.9)
    assert client.said == []
    client.wait(0.2)
    assert [text.text for text in client.said] == ["Operation timeout\t"]
    assert len(client.missions.plan(PlanKind.MISSION)) == 1
    assert client.wait(1.0) == []
    assert client.upload(item(0), item(1), system=7) == RESULT.ACCEPTED


@pytest.mark.parametrize("sequence", [0, 2, 65535])
def test_a_wrong_sequence_number_is_passed_over(client: Client, sequence: int) -> None:
    client.send(count(2))
    client.send(item(0))
    assert client.send(item(sequence)) == []
    assert answer(client.send(item(1))) == ("MISSION_ACK", RESULT.ACCEPTED)


def test_an_item_of_another_list_is_refused(client: Client) -> None:
    client.send(count(1))
    assert answer(client.send(item(0, kind=1))) == ("MISSION_ACK", RESULT.ERROR)
    assert answer(client.send(item(0))) == ("MISSION_ACK", RESULT.ACCEPTED)


def test_another_system_cannot_come_in_between(client: Client) -> None:
    client.send(count(2))
    assert answer(client.send(count(1), 7)) == ("MISSION_ACK", RESULT.ERROR)
    assert client.send(item(0, x=1), 7) == []
    assert client.send(mavlink.MAVLink_mission_clear_all_message(1, 1, 0), 7) == []
    assert client.send(mavlink.MAVLink_mission_set_current_message(1, 1, 0), 7) == []
    assert [text.text for text in client.said] == [
        "REJ. MIS ITEM: partner id mismatch\t",
        "WPM: IGN CLEAR CMD: Busy\t",
        "WPM: IGN WP CURR CMD: Busy\t",
    ]
    assert client.send(acknowledgement(RESULT.CANCELLED), 7) == []
    client.send(item(0))
    assert answer(client.send(item(1))) == ("MISSION_ACK", RESULT.ACCEPTED)
    assert [kept.x for kept in client.missions.plan(PlanKind.MISSION)] == [473977428, 473977429]


def test_a_count_that_was_not_heard_may_come_again(client: Client) -> None:
    client.send(count(2))
    assert answer(client.send(count(1))) == ("MISSION_REQUEST_INT", 0)
    assert answer(client.send(item(0))) == ("MISSION_ACK", RESULT.ACCEPTED)


def test_an_upload_can_be_cancelled(client: Client) -> None:
    client.send(count(2))
    client.send(acknowledgement(RESULT.CANCELLED))
    assert client.wait(1.0) == []
    assert client.upload(item(0), system=7) == RESULT.ACCEPTED


def test_a_download_gives_the_last_item_again_and_no_other(client: Client) -> None:
    client.upload(item(0), item(1), item(2))
    client.send(request_list())
    for sequence in (0, 0, 1):
        assert answer(client.send(request_item(sequence))) == ("MISSION_ITEM_INT", sequence)
    assert answer(client.send(request_item(99))) == ("MISSION_ACK", RESULT.ERROR)
    assert client.send(request_item(99)) == []  # silent, as PX4


def test_an_upload_during_a_download_leaves_the_download_whole(client: Client) -> None:
    client.upload(item(0), item(1))
    client.send(request_list())
    client.send(request_item(0))
    client.upload(item(0, z=1.0), system=7)
    (second,) = client.send(request_item(1))
    assert second.x == 473977429


def test_the_item_that_is_marked_is_where_the_mission_begins(client: Client) -> None:
    client.upload(item(0, current=0), item(1, current=1))
    assert client.missions.progress.sequence == 1


def test_going_to_an_item_is_told_at_once(client: Client) -> None:
    client.upload(item(0), item(1), item(2))
    client.wait(0.004)
    client.told.clear()
    client.send(mavlink.MAVLink_mission_set_current_message(1, 1, 2))
    client.send(mavlink.MAVLink_mission_set_current_message(1, 1, 3))
    assert [(m.get_type(), m.seq, m.total, m.mission_state) for m in client.told] == [
        ("MISSION_CURRENT", 2, 3, 2)
    ]
    assert [text.text for text in client.said] == ["WPM: WP CURR CMD: Not in list\t"]


def test_progress_is_told_when_it_is_made(client: Client) -> None:
    client.upload(item(0), item(1))
    client.wait(0.004)
    client.told.clear()
    client.missions.reached = [0]
    client.missions.progress = client.missions.progress._replace(
        sequence=1, state=MissionState.ACTIVE, in_mission_mode=True
    )
    client.wait(0.02)
    assert names(client.told) == ["MISSION_ITEM_REACHED", "MISSION_CURRENT"]
    reached, current = client.told
    assert reached.seq == 0
    assert (current.seq, current.total, current.mission_state, current.mission_mode) == (1, 2, 3, 1)


numbers = st.floats(width=32, allow_nan=True, allow_infinity=True)
kinds = st.sampled_from([0, 0, 0, 1, 2, 255, 7])
sequences = st.integers(0, 4) | st.integers(0, 65535)
whole = st.integers(-(2**31), 2**31 - 1)
items = st.builds(
    lambda number, kind, x, z, p: item(number, kind, x=x, z=z, param1=p),
    *(sequences, kinds, whole, numbers, numbers),
)
float_items = st.builds(lambda n, x, y: float_item(n, x=x, y=y), sequences, numbers, numbers)
messages = st.one_of(
    items,
    float_items,
    st.builds(count, sequences, kinds),
    st.builds(request_list, kinds),
    st.builds(request_item, sequences, kinds),
    st.builds(acknowledgement, st.integers(0, 20), kinds),
    st.builds(lambda kind: mavlink.MAVLink_mission_clear_all_message(1, 1, kind), kinds),
    st.builds(lambda seq: mavlink.MAVLink_mission_set_current_message(1, 1, seq), sequences),
)
events = st.tuples(messages, st.sampled_from([255, 255, 255, 7]), st.sampled_from([0, 0, 0.3, 6.0]))


@given(st.lists(events, max_size=40))
@settings(deadline=None, max_examples=60)
def test_no_order_of_messages_raises_or_leaves_half_a_plan(script: Any) -> None:
    client = Client()
    announced = {0}  # no list can have a length that nobody announced
    for message, system, seconds in script:
        if message.get_type() == "MISSION_COUNT":
            announced.add(message.count)
        for answered in client.send(message, system):
            answered.pack(mavlink.MAVLink(None))
        client.wait(seconds)
        assert all(len(client.missions.plan(kind)) in announced for kind in KINDS)
    client.wait(6.0)
    assert client.upload(item(0)) == RESULT.ACCEPTED
