"""The link knows its vehicle, logs all, and decodes what is used."""

import math
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from tests.unit.flightstack.mavlink.made_link import VEHICLE, MadeLink, heartbeat


@pytest.fixture
def made(tmp_path: Path) -> MadeLink:
    return MadeLink(tmp_path)


def attitude(stamp_ms: int) -> common.MAVLink_attitude_message:
    return common.MAVLink_attitude_message(stamp_ms, 0, 0, 0, 0, 0, 0)


def position(x_m: float) -> common.MAVLink_local_position_ned_message:
    return common.MAVLink_local_position_ned_message(1000, x_m, 0, 0, 0, 0, 0)


def test_the_first_autopilot_is_the_vehicle(made: MadeLink) -> None:
    made.say(heartbeat(autopilot=8), system=255, component=190)
    made.say(heartbeat(autopilot=8), system=3, component=100)
    made.link.drain()
    assert made.link.vehicle is None
    made.say(heartbeat())
    made.say(heartbeat(), system=4)
    assert [message.get_srcSystem() for message in made.link.drain()] == [3]
    assert made.link.vehicle is not None
    assert (made.link.system_id, made.link.vehicle.autopilot) == (3, 12)


def test_an_invalid_autopilot_is_no_vehicle(made: MadeLink) -> None:
    made.say(heartbeat(autopilot=8))
    made.link.drain()
    assert made.link.vehicle is None


def test_others_cannot_pose_as_the_vehicle(made: MadeLink) -> None:
    made.say(heartbeat())
    made.say(heartbeat(status=4), address=("10.0.0.66", 1))
    assert [message.system_status for message in made.link.drain()] == [3]


def test_speaks_as_the_vehicles_companion_to_where_it_was_heard(made: MadeLink) -> None:
    made.say(heartbeat())
    made.link.drain()
    made.link.send(heartbeat())
    made.link.send(heartbeat())
    first, second = made.sent()
    assert (first.get_srcSystem(), first.get_srcComponent()) == (3, 191)
    assert (first.get_seq(), second.get_seq()) == (0, 1)
    assert made.transport.sent[0][1] == VEHICLE


def test_filters_by_source(made: MadeLink) -> None:
    made.say(heartbeat())
    made.link.drain()
    reached = common.MAVLink_mission_item_reached_message(4)
    made.say(reached)  # the vehicle's own mission, not the referee's
    made.say(reached, system=9, component=25)
    assert made.link.drain() == []
    made.say(reached, component=25)
    assert [message.seq for message in made.link.drain()] == [4]


def test_only_the_newest_position_is_decoded(made: MadeLink) -> None:
    made.say(heartbeat())
    made.link.drain()
    for x_m in (1.0, 2.0, 3.0):
        made.say(position(x_m))
    assert [message.x for message in made.link.drain()] == [3.0]
    assert made.link.drain() == []


def test_stamps_move_the_clock(made: MadeLink) -> None:
    made.say(heartbeat())
    made.say(attitude(0))
    made.link.drain()
    assert made.clock.started
    made.say(attitude(1_700))
    made.say(attitude(1_900), system=9)
    made.link.drain()
    assert made.clock.stamp_us == 1_700_000


def test_silence_is_counted_from_the_vehicles_last_word(made: MadeLink) -> None:
    made.say(heartbeat())
    made.link.drain()
    made.wall.now_s += 2.0
    made.say(heartbeat(autopilot=8), component=100)
    made.link.drain()
    assert made.link.silence_s == pytest.approx(2.0)
    made.transport.closed = True
    assert math.isinf(made.link.silence_s)


def test_logs_both_directions_in_vehicle_time(made: MadeLink) -> None:
    packets = [made.say(heartbeat()), made.say(attitude(5000)), made.say(attitude(6000))]
    foreign = made.say(heartbeat(autopilot=8), system=255)
    made.link.drain()
    made.link.send(heartbeat())
    made.link.close()
    content = made.tlog.path.read_bytes()
    records = [*packets, foreign, made.transport.sent[0][0]]
    assert len(content) == sum(8 + len(packet) for packet in records)
    times_us = []
    for packet in records:
        times_us.append(int.from_bytes(content[:8], "big"))
        assert content[8 : 8 + len(packet)] == packet
        content = content[8 + len(packet) :]
    assert [time_us - times_us[0] for time_us in times_us] == [
        0,
        0,
        1_000_000,
        1_000_000,
        1_000_000,
    ]


@pytest.mark.parametrize("odd_ms", [0, 2**32 - 1, 1_000_000])
def test_a_stamp_that_jumps_alone_is_an_error_and_no_time(tmp_path: Path, odd_ms: int) -> None:
    made = MadeLink(tmp_path)
    made.say(heartbeat())
    for stamp_ms in (100_000, odd_ms, 100_030, odd_ms, 100_060):
        made.say(attitude(stamp_ms))
        made.link.drain()
    assert (made.clock.stamp_us, made.link.restarts) == (100_060_000, 0)


def test_a_vehicle_that_restarts_is_believed_at_its_second_stamp(tmp_path: Path) -> None:
    made = MadeLink(tmp_path)
    made.say(heartbeat())
    for stamp_ms in (100_000, 200, 230):
        made.say(attitude(stamp_ms))
        made.link.drain()
        made.wall.now_s += 3.0
    assert (made.clock.stamp_us, made.link.restarts) == (230_000, 1)


@given(st.lists(st.sampled_from([0, 1, 297_000, 2_000_000, 2**31, 2**32 - 1]), max_size=40))
def test_nobody_restarts_a_vehicle_whose_time_goes_on(odd_ms: list[int]) -> None:
    """Not even by stamps that agree with one another, many between two of the vehicle's own."""
    with tempfile.TemporaryDirectory() as folder:
        made = MadeLink(Path(folder))
        made.say(heartbeat())
        for turn in range(5):
            made.say(attitude(300_000 + 30 * turn))
            for stamp_ms in odd_ms:
                made.say(attitude(stamp_ms))
            made.link.drain()
            made.wall.now_s += 0.03
        assert (made.clock.stamp_us, made.link.restarts) == (300_120_000, 0)


def test_a_vehicle_is_heard_again_after_an_outage(tmp_path: Path) -> None:
    made = MadeLink(tmp_path)
    made.say(heartbeat())
    made.say(attitude(100_000))
    made.link.drain()
    made.wall.now_s += 10.0
    made.say(attitude(110_000))
    made.link.drain()
    assert (made.clock.stamp_us, made.link.restarts) == (110_000_000, 0)
