"""Each check finds what it is for, and says so with figures."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.checks import Finding, Level, load_checks, run_checks
from flightstack.logs.checks.registry import REGISTERED, check
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.made_flights import VEHICLE, make_flight
from tests.unit.flightstack.logs.made_logs import START_US, record


def findings(data: bytes) -> dict[str, Finding]:
    return {finding.name: finding for finding in run_checks(Flight(read_bytes(data)))}


def stamp_of(one: bytes) -> bytes:
    return one[:8]


def with_messages(
    data: bytes, make: Callable[[int], object], start_s: float, end_s: float
) -> bytes:
    """Return the log with a message of the vehicle 50 times a second for a while."""
    sender = mavlink.MAVLink(None, 1, VEHICLE)
    extra = []
    for tick in range(int(start_s * 50), int(end_s * 50)):
        raw = make(tick).pack(sender)  # type: ignore[attr-defined]
        extra.append(record(START_US + tick * 20_000, raw))
    log = read_bytes(data)
    pairs = zip((log.packets.offset - 8).tolist(), log.packets.end.tolist(), strict=True)
    records: list[bytes] = [*(data[start:end] for start, end in pairs), *extra]
    ordered = sorted(records, key=stamp_of)
    return b"".join(ordered)


@pytest.fixture(scope="module")
def healthy() -> dict[str, Finding]:
    return findings(make_flight(20.0, misses=False))


def test_a_healthy_flight_passes_everything(healthy: dict[str, Finding]) -> None:
    assert {f.level for f in healthy.values()} <= {Level.OK, Level.SKIPPED}
    assert healthy["motor_saturation"].level is Level.SKIPPED
    assert all(finding.reason and finding.meaning for finding in healthy.values())


def test_a_missed_gate_is_an_error() -> None:
    found = findings(make_flight(20.0))["course"]
    assert found.level is Level.ERROR
    assert found.reason == "Missed gate 6: passed outside, at 27.9 s, after 5 gates"


def test_unanswered_images_are_a_warning() -> None:
    assert findings(make_flight(8.0, skip=4))["frames_answered"].level is Level.WARNING


def without_setpoints(data: bytes, start_s: float, end_s: float) -> bytes:
    log = read_bytes(data)
    is_setpoint = log.packets.msgid == 84
    seconds = (log.time_us - START_US) * 1e-6
    keep = np.flatnonzero(~(is_setpoint & (seconds >= start_s) & (seconds < end_s)))
    starts, ends = log.packets.offset - 8, log.packets.end
    return b"".join(data[starts[i] : ends[i]] for i in keep.tolist())


@pytest.mark.parametrize(
    ("gap_s", "level"), [(0.3, Level.OK), (0.7, Level.WARNING), (1.3, Level.ERROR)]
)
def test_gaps_between_setpoints_are_judged_by_their_length(gap_s: float, level: Level) -> None:
    data = without_setpoints(make_flight(8.0), 10.0, 10.0 + gap_s)
    assert findings(data)["setpoint_rate"].level is level


def test_late_setpoints_are_found() -> None:
    data = make_flight(8.0)
    log = read_bytes(data)
    late = []
    pieces = zip(log.packets.offset.tolist(), log.packets.end.tolist(), strict=True)
    for row, (start, end) in enumerate(pieces):
        delay_us = 120_000 if log.packets.msgid[row] == 84 else 0
        late.append((int(log.time_us[row]) + delay_us, data[start:end]))
    found = findings(b"".join(record(t, raw) for t, raw in sorted(late)))["stale_frames"]
    assert found.level is Level.ERROR
    assert "124.0 ms" in found.reason


def test_shaking_rates_are_an_oscillation() -> None:
    def shaking(tick: int) -> object:
        rate = 1.5 * np.sin(2 * np.pi * 5.0 * tick / 50)
        return mavlink.MAVLink_attitude_message(tick * 20, 0, 0, 0, rate, rate, 0)

    beat = make_flight(8.0)
    log = read_bytes(beat)
    keep = log.packets.msgid != 30
    starts, ends = log.packets.offset - 8, log.packets.end
    rest = b"".join(beat[starts[i] : ends[i]] for i in np.flatnonzero(keep).tolist())
    found = findings(with_messages(rest, shaking, 0, 20))["oscillation"]
    assert found.level is Level.WARNING
    assert found.reason.startswith("1.0")  # root mean square of 1.5 sin


def test_a_motor_at_its_limit_is_found() -> None:
    def full(tick: int) -> object:
        return mavlink.MAVLink_servo_output_raw_message(tick, 0, 2000, 1500, 1500, 1500, 0, 0, 0, 0)

    assert findings(with_messages(make_flight(8.0), full, 9, 15))["motor_saturation"].level is (
        Level.WARNING
    )


def test_a_failsafe_is_an_error() -> None:
    def critical(tick: int) -> object:
        return mavlink.MAVLink_heartbeat_message(2, 12, 209, 0x00030000, 5, 3 + 0 * tick)

    found = findings(with_messages(make_flight(8.0), critical, 24, 25))["failsafe"]
    assert found.level is Level.ERROR


def test_a_position_that_jumps_is_found() -> None:
    def elsewhere(tick: int) -> object:
        return mavlink.MAVLink_local_position_ned_message(tick * 20, 30.0, 0, -3, 0, 0, 0)

    data = make_flight(8.0)
    log = read_bytes(data)
    before = data[: int(log.packets.end[log.time_us <= START_US + 12_000_000][-1])]
    found = findings(with_messages(before, elsewhere, 12, 13))["estimate_jump"]
    assert found.level is Level.WARNING


@pytest.mark.parametrize(
    ("every", "level"), [(200, Level.OK), (40, Level.WARNING), (10, Level.ERROR)]
)
def test_link_loss_is_judged_by_its_share(every: int, level: Level) -> None:
    data = make_flight(8.0)
    log = read_bytes(data)
    starts, ends = log.packets.offset - 8, log.packets.end
    kept = [data[starts[i] : ends[i]] for i in range(len(log)) if i % every]
    assert findings(b"".join(kept))["link_loss"].level is level


def test_users_add_their_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        "from flightstack.logs.checks import Level, check\n"
        '@check("height", title="Height", meaning="Mind the ceiling.")\n'
        "def height(flight):\n"
        "    top = -flight.motion.position_ned[:, 2].min()\n"
        '    return (Level.WARNING if top > 2 else Level.OK), f"{top:.1f} m"\n'
    )
    try:
        load_checks(path)
        found = findings(make_flight(5.0))["height"]
        assert (found.level, found.reason) == (Level.WARNING, "3.1 m")
    finally:
        REGISTERED.pop("height", None)


def test_a_check_that_fails_is_a_finding_not_a_crash() -> None:
    @check("broken", title="Broken", meaning="Never.")
    def broken(_: Flight) -> tuple[Level, str]:
        raise ValueError("no luck")

    try:
        assert findings(make_flight(3.0))["broken"].reason.endswith("ValueError: no luck")
    finally:
        REGISTERED.pop("broken")


def test_a_file_of_checks_that_cannot_be_loaded_says_why(tmp_path: Path) -> None:
    with pytest.raises(LogFileError, match="no such Python file"):
        load_checks(tmp_path / "none.py")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("def x(:\n")
    with pytest.raises(LogFileError, match="cannot be loaded"):
        load_checks(wrong)
