import math
from collections import Counter

import pytest

from sitl.clock import SECOND_US, TICK_US
from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.rates import (
    GROUND_STATION,
    MAX_QUEUE,
    NORMAL,
    OFFBOARD_API,
    Profile,
    StreamTable,
)
from sitl.mavlink.wire.dialect import mavlink

ATTITUDE = mavlink.MAVLINK_MSG_ID_ATTITUDE
GROUND_TRUTH = mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION


def counts(table: StreamTable, from_us: int, seconds: int) -> Counter[int]:
    times = range(from_us, from_us + seconds * SECOND_US, TICK_US)
    return Counter(message_id for t in times for message_id in table.due(t))


@pytest.mark.parametrize("profile", [GROUND_STATION, OFFBOARD_API])
def test_every_stream_keeps_its_rate_exactly(profile: Profile) -> None:
    sent = counts(StreamTable(profile), 0, 20)
    assert sent == {
        message_id: math.ceil(20 * rate) for message_id, rate in profile.at_start.items()
    }


@pytest.mark.parametrize("profile", [GROUND_STATION, OFFBOARD_API])
def test_only_what_can_be_encoded_is_streamed(profile: Profile) -> None:
    assert set(profile.at_start) | set(profile.default) <= set(ENCODERS)


def test_what_is_due_together_comes_in_the_order_of_ids() -> None:
    due = StreamTable(GROUND_STATION).due(0)
    assert due == sorted(GROUND_STATION.at_start)
    assert due[0] == mavlink.MAVLINK_MSG_ID_HEARTBEAT


def test_a_rate_can_be_changed_stopped_and_set_back_to_the_links_default() -> None:
    table = StreamTable(GROUND_STATION)
    assert table.interval_us(ATTITUDE) == 20_000
    assert table.set_interval(ATTITUDE, 50_000, 0)
    assert counts(table, 0, 2)[ATTITUDE] == 40
    assert table.interval_us(ATTITUDE) == 50_000
    assert table.set_interval(ATTITUDE, -1, 2 * SECOND_US)
    assert counts(table, 2 * SECOND_US, 2)[ATTITUDE] == 0
    assert table.interval_us(ATTITUDE) == -1
    assert table.set_interval(ATTITUDE, 0, 4 * SECOND_US)
    assert counts(table, 4 * SECOND_US, 2)[ATTITUDE] == 2 * NORMAL[ATTITUDE] == 30


def test_ground_truth_comes_on_request_only() -> None:
    table = StreamTable(OFFBOARD_API)
    assert counts(table, 0, 1)[GROUND_TRUTH] == 0
    assert table.set_interval(GROUND_TRUTH, 20_000, SECOND_US)
    assert counts(table, SECOND_US, 1)[GROUND_TRUTH] == 50
    assert table.set_interval(GROUND_TRUTH, 0, 2 * SECOND_US)
    assert counts(table, 2 * SECOND_US, 1)[GROUND_TRUTH] == 0


def test_heartbeat_cannot_be_changed() -> None:
    table = StreamTable(GROUND_STATION)
    assert not table.set_interval(mavlink.MAVLINK_MSG_ID_HEARTBEAT, -1, 0)
    assert counts(table, 0, 3)[mavlink.MAVLINK_MSG_ID_HEARTBEAT] == 3


def test_endless_changes_while_time_stands_cost_bounded_memory() -> None:
    table = StreamTable(GROUND_STATION)
    for _ in range(10 * MAX_QUEUE):
        table.set_interval(ATTITUDE, 2**31 - 1, 0)
    assert len(table._queue) <= MAX_QUEUE
    assert counts(table, 0, 1)[ATTITUDE] == 1
