"""What a client sends again because an answer was lost gets the same answer again."""

import pytest

from sitl.records.missions import MissionResult
from tests.unit.sitl.mavlink.servers.made_missions import (
    Client,
    acknowledgement,
    count,
    item,
    names,
    request_item,
    request_list,
)

RESULT = MissionResult


@pytest.fixture
def client() -> Client:
    return Client()


@pytest.mark.parametrize("result", [RESULT.ACCEPTED, RESULT.DENIED])
def test_the_last_item_again_has_the_plans_result_again(
    client: Client, result: MissionResult
) -> None:
    client.missions.plan_result = result
    assert client.upload(item(0), item(1)) == result
    for _ in range(2):
        (again,) = client.send(item(1))
        assert (again.get_type(), again.type, again.mission_type) == ("MISSION_ACK", result, 0)
    assert client.said == []


@pytest.mark.parametrize("sequence", [0, 2, 65535])
def test_another_item_after_the_end_is_an_error(client: Client, sequence: int) -> None:
    client.upload(item(0), item(1))
    (refused,) = client.send(item(sequence))
    assert refused.type == RESULT.ERROR
    assert [text.text for text in client.said] == ["IGN MISSION_ITEM: No transfer\t"]


def test_the_last_item_of_somebody_else_is_passed_over(client: Client) -> None:
    client.upload(item(0))
    assert client.send(item(0), 7) == []
    assert client.send(item(0, kind=1))[0].type == RESULT.ERROR


def test_an_item_after_a_refusal_was_not_taken(client: Client) -> None:
    client.send(count(2))
    client.send(item(0))
    client.missions.item_result = RESULT.UNSUPPORTED
    assert client.send(item(1))[0].type == RESULT.UNSUPPORTED
    client.missions.item_result = RESULT.ACCEPTED
    assert client.send(item(0))[0].type == RESULT.ERROR
    assert client.send(item(1))[0].type == RESULT.ERROR


def test_an_item_out_of_nothing_is_nobodys(client: Client) -> None:
    assert client.send(item(0)) == []
    assert [text.text for text in client.said] == ["REJ. MIS ITEM: partner id mismatch\t"]


def test_the_list_again_begins_the_download_again_but_no_other_list(client: Client) -> None:
    client.upload(item(0), item(1))
    client.send(request_list())
    client.send(request_item(0))
    assert client.send(request_list(1)) == []
    assert client.send(request_list())[0].count == 2
    assert [client.send(request_item(n))[0].seq for n in (0, 0, 1, 1)] == [0, 0, 1, 1]
    assert client.send(request_list(1))[0].count == 0  # the download's last answer got lost


def test_a_client_that_knows_no_integers_is_asked_for_floats(client: Client) -> None:
    assert names(client.send(count(2))) == ["MISSION_REQUEST_INT"]
    (asked,) = client.send(acknowledgement(RESULT.UNSUPPORTED))
    assert (asked.get_type(), asked.seq) == ("MISSION_REQUEST", 0)
    assert names(client.wait(0.3)) == ["MISSION_REQUEST"]
