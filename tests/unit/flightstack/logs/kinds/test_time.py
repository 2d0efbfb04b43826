"""One notion of time: whatever is wrong with the stamps, a minute of flight is a minute."""

import struct
from collections.abc import Callable

import numpy as np
import pytest

from flightstack.logs import Log, read_bytes
from flightstack.logs.checks import Level, run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.kinds.made_vehicles import (
    PX4,
    SECOND,
    Entry,
    Sender,
    Vehicle,
    entries,
    facts_of,
    tlog,
)
from tests.unit.flightstack.logs.made_logs import START_US

PLAIN = entries(Vehicle())


def unsorted(rows: list[Entry]) -> bytes:
    return b"".join(struct.pack(">Q", time_us % 2**64) + raw for time_us, raw in rows)


def assert_a_minute(log: Log) -> None:
    facts = summarise(Flight(log), [])
    assert facts["duration_s"] == pytest.approx(59.9, abs=0.3)
    assert facts["armed_time_s"] == pytest.approx(40.0, abs=1.1)
    assert facts["flights"] == 1
    assert np.all(np.diff(log.time_us) >= -SECOND)


@pytest.mark.parametrize(
    "noise", [b"garbage of forty bytes, which is no time", b"\0" * 9, b"OK\r\n"]
)
@pytest.mark.parametrize("version", [1, 2])
def test_a_stream_without_stamps_takes_none_from_what_lies_between(
    noise: bytes, version: int
) -> None:
    rows = entries(Vehicle(), Sender(version=version))
    raw = [packet for _, packet in rows]
    for place in (300, 301, 700):
        raw[place] = noise + raw[place]
    log = read_bytes(b"".join(raw))
    assert not log.damage.has_times
    assert_a_minute(log)


def damaged(
    rows: list[Entry], wrong: Callable[[int, int], int], runs: list[tuple[int, int]]
) -> bytes:
    changed = list(rows)
    for first, count in runs:
        for place in range(first, first + count):
            changed[place] = (wrong(changed[place][0], place), changed[place][1])
    return unsorted(changed)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda time, _place: time + 2**60,
        lambda _time, place: 2**63 + place,
        lambda _time, place: place,
        lambda time, _place: time - 3600 * SECOND,
        lambda time, _place: time + 3600 * SECOND,
        lambda time, _place: time + 20 * SECOND,
    ],
)
@pytest.mark.parametrize("runs", [[(400, 1)], [(200, 10)], [(100, 30), (600, 7), (900, 25)]])
def test_stamps_damaged_in_runs_are_mended(
    wrong: Callable[[int, int], int], runs: list[tuple[int, int]]
) -> None:
    log = read_bytes(damaged(PLAIN, wrong, runs))
    assert_a_minute(log)
    assert int(log.time_us[0]) == START_US
    assert log.damage.mended_times == sum(count for _, count in runs)
    assert not log.damage.jumps
    assert np.abs(log.time_us - [time for time, _ in PLAIN]).max() < 0.2 * SECOND


@pytest.mark.parametrize("before", [0, 315_532_800 * SECOND, START_US + 90 * SECOND])
def test_a_clock_set_while_logging_changes_no_duration(before: int) -> None:
    rows = [
        (before + time - START_US if place < 450 else time, raw)
        for place, (time, raw) in enumerate(PLAIN)
    ]
    log = read_bytes(unsorted(rows))
    assert_a_minute(log)
    assert len(log.damage.jumps) == 1
    if before < START_US:
        assert int(log.time_us[-1]) == PLAIN[-1][0]  # the clock that was set is the true one


def test_line_ends_converted_in_the_file_are_undone() -> None:
    rows = [(time + 0x0A0A, raw) for time, raw in entries(Vehicle(boot_ms=0x0A0A00))]
    whole = tlog(rows)
    log = read_bytes(whole.replace(b"\n", b"\r\n"))
    assert log.counts == read_bytes(whole).counts
    assert not log.damage.regions
    assert "undone" in log.damage.line_ends
    assert read_bytes(whole).damage.line_ends == ""


def test_line_ends_that_cannot_be_undone_are_told() -> None:
    whole = tlog(entries(Vehicle(boot_ms=0x0D0A00))).replace(b"\r", b"\n")
    log = read_bytes(whole)
    assert "carriage return" in log.damage.line_ends
    assert "carriage return" in summarise(Flight(log), [])["damage"]["line_ends"]


def in_bursts(rows: list[Entry], every_s: float) -> list[Entry]:
    step = round(every_s * SECOND)
    return [(-(-time // step) * step, raw) for time, raw in rows]


@pytest.mark.parametrize("every_s", [0.7, 2.5])
def test_what_comes_in_bursts_is_no_jump_of_the_estimate(every_s: float) -> None:
    rows = entries(Vehicle(type=1, speed_m_s=25.0, armed_s=(0.0, 60.0), down=lambda _t: -50.0))
    flight = Flight(read_bytes(tlog(in_bursts(rows, every_s))))
    found = {finding.name: finding for finding in run_checks(flight)}
    assert found["estimate_jump"].level is Level.OK
    assert flight.motion.distance_m() == pytest.approx(59.9 * 25.0, rel=0.01)


def test_a_shaking_vehicle_shakes_as_fast_whatever_the_link_does() -> None:
    def levels(rows: list[Entry]) -> Level:
        flight = Flight(read_bytes(tlog(rows)))
        return {each.name: each.level for each in run_checks(flight)}["oscillation"]

    shaking = entries(Vehicle(autopilot=PX4, rate_hz=40))
    assert levels(shaking) is levels(in_bursts(shaking, 1.0))


def test_a_restart_is_an_event_and_its_counter_no_loss() -> None:
    first = entries(Vehicle(armed_s=(5.0, 25.0), end_s=30.0, boot_ms=90_000))
    again = entries(Vehicle(armed_s=(5.0, 25.0), end_s=30.0))
    rows = [*first, *((time + 35 * SECOND, raw) for time, raw in again)]
    facts = facts_of(rows)
    assert [round(each["at_s"]) for each in facts["restarts"]] == [35]
    assert [link["lost"] for link in facts["links"]] == [0]
    levels = {each["name"]: each["level"] for each in facts["checks"]}
    assert levels["link_loss"] == "ok"
