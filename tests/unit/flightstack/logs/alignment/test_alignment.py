"""Two logs of one flight on one axis: by boot time, by attitude, or not at all."""

import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import LogFileError, read, read_bytes
from flightstack.logs.alignment.alignment import align
from flightstack.logs.alignment.boot_clock_fit import fit_boot_clock
from flightstack.logs.cli import main
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.made_flights import beat
from tests.unit.flightstack.logs.made_logs import START_US
from tests.unit.flightstack.logs.made_onboard import Sway, ardupilot_log, px4_log, sway, times_us

OFFBOARD = 0x00060000
Delay = Callable[[int], int]


def late_by_turns(boot_us: int) -> int:
    """Return the delay of a link: 0 to 40 ms, in turns."""
    return boot_us // 50_000 % 5 * 10_000


def companion_log(
    delay: Delay,
    *,
    boot_shift_us: int = 0,
    rate: float = 0.0,
    flown: Callable[[float], Sway] = sway,
) -> bytes:
    """Return a tlog of the made flight, with the attitude at 10 Hz and a setpoint at 20 Hz.

    The vehicle's clock is `boot_shift_us` ahead of the vehicle's own log, the tlog's clock runs
    faster by `rate`.
    """
    vehicle, companion = mavlink.MAVLink(None, 7, 1), mavlink.MAVLink(None, 7, 191)
    parts = []
    for t in times_us():
        boot_ms = (t + boot_shift_us) // 1000
        m = flown(t * 1e-6)
        messages = [(companion, mavlink.MAVLink_set_position_target_local_ned_message(
            boot_ms, 7, 1, 1, 0b010111000111, 0, 0, 0, *m.velocity, 0, 0, 0, 0, 0))]  # fmt: skip
        if t % 100_000 == 0:
            angles = (m.roll, m.pitch, m.yaw)
            messages += [
                (vehicle, mavlink.MAVLink_attitude_message(boot_ms, *angles, 0, 0, 0)),
                (vehicle, mavlink.MAVLink_local_position_ned_message(
                    boot_ms, *m.position, *m.velocity)),
                (vehicle, beat(OFFBOARD, armed=2 <= t * 1e-6 < 36)),
            ]  # fmt: skip
        for sender, message in messages:
            late_us = delay(t) if sender is vehicle else 0
            stamp = START_US + round(t * (1 + rate)) + late_us
            parts.append(struct.pack(">Q", stamp) + message.pack(sender))
    return b"".join(parts)


@pytest.fixture(params=["vehicle.ulg", "vehicle.bin"])
def own(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path: Path = tmp_path / request.param
    path.write_bytes(px4_log() if path.suffix == ".ulg" else ardupilot_log())
    return path


def error_ms(companion: bytes, own: Path, rate: float = 0.0) -> float:
    """Return by how much the vehicle's own times land beside the true ones on the tlog's axis."""
    flight, other = Flight(read_bytes(companion)), Flight(read(own))
    alignment = align(flight, other)
    table = other.log["ATTITUDE"]
    boot_us = table["time_boot_ms"].astype(np.float64) * 1e3
    true = START_US + boot_us * (1 + rate)
    return float(np.abs(alignment.log_us(table.time_us) - true).max()) * 1e-3


def test_one_boot_is_aligned_by_its_clock(own: Path) -> None:
    companion = companion_log(late_by_turns)
    alignment = align(Flight(read_bytes(companion)), Flight(read(own)))
    assert alignment.method == "boot time"
    assert alignment.residual_rad < 2e-4
    assert alignment.late_ms == pytest.approx(40, abs=5)
    assert error_ms(companion, own) < 2


def test_clocks_of_other_rates_are_aligned_throughout(own: Path) -> None:
    companion = companion_log(late_by_turns, rate=0.012)
    assert error_ms(companion, own, rate=0.012) < 5
    assert "runs +1.2" in align(Flight(read_bytes(companion)), Flight(read(own))).words()


def test_another_clock_is_aligned_by_attitude(own: Path) -> None:
    companion = companion_log(late_by_turns, boot_shift_us=7_654_000)
    alignment = align(Flight(read_bytes(companion)), Flight(read(own)))
    assert alignment.method == "attitude"
    assert alignment.correlation > 0.99
    assert error_ms(companion, own) < 15


def test_a_restart_before_the_flight_does_no_harm(own: Path) -> None:
    vehicle = mavlink.MAVLink(None, 7, 1)
    before = [
        struct.pack(">Q", START_US - 60_000_000 + t)
        + mavlink.MAVLink_attitude_message(50_000 + t // 1000, 0, 0, 0, 0, 0, 0).pack(vehicle)
        for t in range(0, 20_000_000, 100_000)
    ]
    assert error_ms(b"".join(before) + companion_log(late_by_turns), own) < 2


def test_another_flight_is_refused(own: Path) -> None:
    def other_sway(t: float) -> Sway:
        m = sway(t)
        rng = np.random.default_rng(int(t * 1000))
        roll, pitch = rng.normal(0, 0.2, 2).tolist()
        return Sway(roll, pitch, m.yaw, m.position, m.velocity)

    flight = Flight(read_bytes(companion_log(late_by_turns, flown=other_sway)))
    with pytest.raises(LogFileError, match="do not look like one flight"):
        align(flight, Flight(read(own)))


def test_the_clock_lies_under_every_packet() -> None:
    rng = np.random.default_rng(3)
    boot_us = np.arange(0, 60_000_000, 20_000)
    log_us = START_US + (boot_us * 1.0001).astype(np.int64) + rng.integers(0, 50_000, len(boot_us))
    clock = fit_boot_clock(log_us, boot_us)
    assert clock.rate == pytest.approx(1e-4, abs=5e-5)
    assert (clock.log_us(boot_us) <= log_us + 1).all()
    assert clock.boot_us(clock.log_us(boot_us)) == pytest.approx(boot_us, abs=1)


def test_the_report_stands_beside_the_vehicles_own_log(
    own: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    companion = tmp_path / "companion.tlog"
    companion.write_bytes(companion_log(late_by_turns))
    page = tmp_path / "page.html"
    assert main(["report", str(companion), "--with", str(own), "-o", str(page), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["with"]
    assert (facts["method"], facts["log"]) == ("boot time", str(own))
    assert facts["lags_s"]["done"]["vx"] == pytest.approx(0, abs=0.05)
    text = page.read_text()
    assert "Beside the vehicle" in text
    figures = json.loads(text.partition('id="figures">')[2].partition("</script>")[0])
    names = {trace["name"] for trace in figures["beside"]["data"]}
    assert {"companion commands", "estimator says", "companion is told", "output 4"} <= names
    assert main(["report", str(companion), "--with", str(own), "-o", str(page)]) == 0
    assert "aligned by boot time" in capsys.readouterr().out
