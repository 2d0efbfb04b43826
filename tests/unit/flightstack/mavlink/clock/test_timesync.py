"""TIMESYNC is asked where it is wanted, and only its own answers set the clock."""

from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.vehicle_session import VehicleSession
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

AHEAD_S = 7.0  # the vehicle's clock, of ours
NS = 1_000_000_000


class Asked:
    """A session whose vehicle answers as often as the test lets it."""

    def __init__(self, folder: Path) -> None:
        self.made = MadeLink(folder)
        self.session = VehicleSession(self.made.link, 3.0)
        self.made.say(heartbeat())
        self.made.say(common.MAVLink_attitude_message(57_000, 0, 0, 0, 0, 0, 0))
        self.session.receive()

    def questions(self) -> list[Any]:
        sent = self.made.sent()
        return [m for m in sent if m.get_type() == "TIMESYNC"]

    def exchange(self, count: int, **answer: Any) -> None:
        for _ in range(count):
            self.session.keep_up(0)
            vehicle_s = self.made.wall.now_s + 0.01 + AHEAD_S
            self.made.wall.now_s += 0.02
            question = self.questions()[-1]
            fields = {"tc1": round(vehicle_s * NS), "ts1": question.ts1} | answer
            self.made.say(common.MAVLink_timesync_message(**fields))
            self.session.receive()
            self.made.wall.now_s += 0.1


@pytest.fixture
def asked(tmp_path: Path) -> Asked:
    return Asked(tmp_path)


def test_nothing_is_asked_unless_it_is_wanted(asked: Asked) -> None:
    for _ in range(50):
        asked.made.wall.now_s += 0.1
        asked.session.keep_up(0)
    assert asked.questions() == []


def test_asks_ten_times_a_second(asked: Asked) -> None:
    asked.session.timesync.begin()
    for _ in range(200):
        asked.made.wall.now_s += 0.01
        asked.session.keep_up(0)
    assert len(asked.questions()) == pytest.approx(20, abs=2)
    assert {question.tc1 for question in asked.questions()} == {0}


def test_answers_tell_the_vehicles_time_at_any_moment(asked: Asked) -> None:
    clock = asked.made.clock
    asked.session.timesync.begin()
    asked.exchange(4)
    assert not clock.synchronised
    asked.exchange(4)
    assert clock.at_us(40.0) == pytest.approx((40.0 + AHEAD_S) * 1e6, abs=10)
    assert clock.now_us() == pytest.approx((asked.made.wall.now_s + AHEAD_S) * 1e6, abs=10)
    quality = asked.session.timesync.quality
    assert quality is not None
    assert quality.offset_s == pytest.approx(AHEAD_S, abs=1e-5)
    assert quality.round_trip_s == pytest.approx(0.02, abs=1e-6)
    assert quality.uncertainty_s == pytest.approx(0.01, abs=1e-5)


@pytest.mark.parametrize("answer", [{"ts1": 5}, {"tc1": 0}, {"tc1": -1}])
def test_what_is_no_answer_of_ours_changes_nothing(asked: Asked, answer: dict[str, int]) -> None:
    asked.session.timesync.begin()
    asked.exchange(10, **answer)
    assert not asked.made.clock.synchronised


def test_a_restart_forgets_the_clock(asked: Asked) -> None:
    asked.session.timesync.begin()
    asked.exchange(8)
    for stamp_ms in (1_000, 1_010):  # one alone could be a packet that came late
        asked.made.say(common.MAVLink_attitude_message(stamp_ms, 0, 0, 0, 0, 0, 0))
    asked.session.receive()
    assert not asked.made.clock.synchronised
    assert asked.session.timesync.quality is None
