"""Two flights compared message by message: what differs is found, what does not repeat is not."""

import struct
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink
from pymavlink.dialects.v20.development import (
    MAVLink_attitude_message,
    MAVLink_heartbeat_message,
    MAVLink_system_time_message,
)

from scripts.compare.comparison import Unrepeated, compare, learn, learn_all
from scripts.compare.messages import (
    Message,
    Reader,
    ending_message,
    read_tlog,
    without_repeated_heartbeats,
)
from scripts.compare.words import packed

ATTITUDE, BEAT, CLOCK = "gcs 1/1 ATTITUDE", "gcs 1/1 HEARTBEAT", "gcs 1/1 SYSTEM_TIME"
NOTHING = Unrepeated()


def attitude(roll: float = 0.1, time_ms: int = 4) -> MAVLink_attitude_message:
    return mavlink.MAVLink_attitude_message(time_ms, roll, 0.0, 0.0, 0.0, 0.0, 0.0)


def beat(mode: int = 0) -> MAVLink_heartbeat_message:
    return mavlink.MAVLink_heartbeat_message(2, 12, 0, mode, 4, 3)


def clock(unix_us: int) -> MAVLink_system_time_message:
    return mavlink.MAVLink_system_time_message(unix_us, 5)


def flight(*messages: Any) -> list[Message]:
    codec = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
    reader = Reader()
    return [m for message in messages for m in reader.read(packed(message, codec), "gcs")]


def test_equal_flights_have_no_difference() -> None:
    first, second = flight(attitude(), beat()), flight(attitude(), beat())
    assert learn(first, second) == NOTHING
    assert str(NOTHING) == ""
    assert compare(first, second, NOTHING) is None


def test_the_last_bit_of_a_field_is_found() -> None:
    (bits,) = struct.unpack("<I", struct.pack("<f", 0.1))
    (next_to_it,) = struct.unpack("<f", struct.pack("<I", bits + 1))
    first, second = flight(beat(), attitude(0.1)), flight(beat(), attitude(next_to_it))
    difference = compare(first, second, NOTHING)
    assert difference is not None
    assert (difference.place, difference.name, difference.field) == (1, ATTITUDE, "roll")
    assert difference.first != difference.second


def test_minus_zero_is_not_zero_and_nan_is_nan() -> None:
    assert compare(flight(attitude(0.0)), flight(attitude(-0.0)), NOTHING) is not None
    nan = float("nan")
    assert compare(flight(attitude(nan)), flight(attitude(nan)), NOTHING) is None


@pytest.mark.parametrize(
    "second",
    [(attitude(), beat()), (beat(), attitude(), attitude()), (beat(),), (attitude(),), ()],
    ids=["order", "more", "fewer", "another", "none"],
)
def test_number_and_order_count(second: Any) -> None:
    assert compare(flight(beat(), attitude()), flight(*second), NOTHING) is not None


def test_a_skipped_sequence_number_is_found() -> None:
    first, second = flight(beat(), attitude()), flight(beat(), attitude())
    second[1] = second[1]._replace(step=2)
    difference = compare(first, second, NOTHING)
    assert difference is not None
    assert difference.field == "(sequence number)"


def test_a_field_that_does_not_repeat_is_left_out_and_no_other() -> None:
    first, again = flight(attitude(0.1), beat()), flight(attitude(0.2), beat())
    unrepeated = learn(first, again)
    assert unrepeated == Unrepeated(fields=frozenset({(ATTITUDE, "roll")}))
    assert compare(first, flight(attitude(0.3), beat()), unrepeated) is None
    difference = compare(first, flight(attitude(0.3, time_ms=8), beat()), unrepeated)
    assert difference is not None
    assert difference.field == "time_boot_ms"


def test_a_shifted_clock_is_compared_from_its_first_value_on() -> None:
    first, again = flight(clock(1000), clock(1010)), flight(clock(5000), clock(5010))
    unrepeated = learn(first, again)
    assert unrepeated == Unrepeated(shifted=frozenset({(CLOCK, "time_unix_usec")}))
    assert compare(first, flight(clock(70), clock(80)), unrepeated) is None
    assert compare(first, flight(clock(70), clock(81)), unrepeated) is not None


def test_a_type_whose_number_does_not_repeat_is_left_out() -> None:
    first, again = flight(beat(), attitude()), flight(beat(), beat(), attitude())
    unrepeated = learn(first, again)
    assert unrepeated == Unrepeated(types=frozenset({BEAT}))
    assert compare(first, flight(attitude()), unrepeated) is None


def test_a_type_without_a_place_is_compared_among_itself() -> None:
    first = flight(attitude(0.1), beat(), attitude(0.2), attitude(0.3))
    again = flight(attitude(0.1), attitude(0.2), attitude(0.3), beat())
    unrepeated = learn(first, again)
    assert unrepeated == Unrepeated(places=frozenset({BEAT}))
    second = [attitude(0.1), attitude(0.2), beat(), attitude(0.3)]
    assert compare(first, flight(*second), unrepeated) is None
    assert compare(first, flight(*second[:2], beat(7), second[3]), unrepeated) is not None
    assert compare(first, flight(*second[::-1]), unrepeated) is not None


def test_the_first_of_several_differences_is_told() -> None:
    first = flight(attitude(0.1), attitude(0.2), attitude(0.3))
    second = flight(attitude(0.1), attitude(0.7), attitude(0.8))
    difference = compare(first, second, NOTHING)
    assert difference is not None
    assert difference.place == 1
    assert str(difference).startswith(f"message 1: {ATTITUDE}.roll was 0.2")


def test_heartbeats_of_a_standing_vehicle_do_not_count() -> None:
    trigger = mavlink.MAVLink_camera_trigger_message(0, 0)
    standing = flight(beat(), attitude(), trigger, beat(), beat(), attitude(), beat())
    names = [message.name for message in without_repeated_heartbeats(standing)]
    assert names == [BEAT, ATTITUDE, "gcs 1/1 CAMERA_TRIGGER", ATTITUDE, BEAT]


def test_a_tlog_is_read_without_its_stamps(tmp_path: Path) -> None:
    path = tmp_path / "flight.tlog"
    packets = flight(beat(), attitude())
    path.write_bytes(b"".join(b"\1" * 8 + message.packet for message in packets))
    assert list(read_tlog(path, "gcs")) == packets


def test_the_result_of_a_process_is_compared() -> None:
    first, second = (ending_message("companion", code, {"gates": 8}) for code in (0, 1))
    difference = compare([first], [second], NOTHING)
    assert difference is not None
    assert difference.field == "exit_code"


def test_several_flights_tell_more_of_what_does_not_repeat() -> None:
    flights = [flight(attitude(0.1), beat()), flight(attitude(0.2), beat())]
    flights.append(flight(attitude(0.1, time_ms=8), beat(3)))
    assert learn_all(flights).fields == {
        (ATTITUDE, "roll"),
        (ATTITUDE, "time_boot_ms"),
        (BEAT, "custom_mode"),
    }
