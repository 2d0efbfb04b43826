"""The companion flies the course by what it sees, and the same seeds give the same flight."""

import itertools
import sys
from pathlib import Path
from typing import Any

import pytest

from flightstack.launch.instances import free_instance
from tests.flight import tlogs
from tests.flight.processes import Ended, process, run, run_module
from tests.paths import ROOT

pytestmark = pytest.mark.flight
FLY = [sys.executable, str(ROOT / "scripts" / "fly_course.py"), "--json"]
BODY_NED = 8
VELOCITY_AND_YAW_RATE = 0x5C7  # ignore position, acceleration and yaw
GROUND_STATION_PORT = 15550  # not 14550, where somebody may be listening; + instance
FREE_SPEED_FACTOR = 2.0  # time does not wait for the companion here
NOISY = ("--track-seed=7", "--noise=1.0,2.0")


def fly(*options: str, timeout_s: float = 120.0) -> Ended:
    return run([*FLY, *options], timeout_s=timeout_s)


def messages_of(flight: Ended) -> list[Any]:
    return tlogs.read(ROOT / flight.result["log"])


@pytest.fixture(scope="module")
def noise_free() -> Ended:
    return fly("--fast", "--noise=0,0")


@pytest.fixture(scope="module")
def noisy() -> Ended:
    return fly("--fast", *NOISY)


def test_passes_every_gate_of_the_noise_free_course(noise_free: Ended) -> None:
    assert noise_free.code == 0, noise_free.stderr
    result = noise_free.result
    assert (result["gates_passed"], result["gates_total"]) == (8, 8)
    assert result["outcome"] == "completed"
    assert result["noise"] == [0.0, 0.0]
    assert result["real_time_factor"] > 1.0


def test_log_holds_20_body_velocity_setpoints_a_second(noise_free: Ended) -> None:
    setpoints = tlogs.of_type(messages_of(noise_free), "SET_POSITION_TARGET_LOCAL_NED")
    assert {(m.coordinate_frame, m.type_mask) for m in setpoints} == {
        (BODY_NED, VELOCITY_AND_YAW_RATE)
    }
    stamps_ms = [m.time_boot_ms for m in setpoints]
    gaps_ms = {after - before for before, after in itertools.pairwise(stamps_ms)}
    assert gaps_ms <= {48, 52}  # 12 or 13 ticks of 4 ms
    rate_hz = (len(stamps_ms) - 1) / (stamps_ms[-1] - stamps_ms[0]) * 1e3
    assert rate_hz == pytest.approx(20.0, abs=0.01)


def test_log_holds_the_uncertainty_of_every_decision(noise_free: Ended) -> None:
    decisions = tlogs.of_type(messages_of(noise_free), "DEBUG_FLOAT_ARRAY")
    assert len(decisions) > 100
    assert all(min(m.data[:12]) >= 0.0 and max(m.data[:12]) > 0.0 for m in decisions)


def test_mavlogdump_reads_the_log(noise_free: Ended) -> None:
    mavlogdump = Path(sys.executable).with_name("mavlogdump.py")
    command = [str(mavlogdump), "--types=SET_POSITION_TARGET_LOCAL_NED", noise_free.result["log"]]
    dumped = run([sys.executable, *command], timeout_s=60.0)
    assert dumped.code == 0, dumped.stderr
    assert "coordinate_frame : 8, type_mask : 1479" in dumped.stdout


def trace(flight: Ended) -> list[tuple[float, ...]]:
    """Every position and velocity the companion was told between its first and last command."""
    messages = messages_of(flight)
    setpoints = tlogs.of_type(messages, "SET_POSITION_TARGET_LOCAL_NED")
    first_ms, last_ms = setpoints[0].time_boot_ms, setpoints[-1].time_boot_ms
    return [
        (m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz)
        for m in tlogs.of_type(messages, "LOCAL_POSITION_NED")
        if first_ms <= m.time_boot_ms <= last_ms
    ]


def commands(flight: Ended) -> list[tuple[float, ...]]:
    return [
        (m.time_boot_ms, m.vx, m.vy, m.vz, m.yaw_rate)
        for m in tlogs.of_type(messages_of(flight), "SET_POSITION_TARGET_LOCAL_NED")
    ]


def gates(flight: Ended) -> list[int]:
    return [m.seq for m in tlogs.of_type(messages_of(flight), "MISSION_ITEM_REACHED")]


@pytest.mark.parametrize("speed", [("--fast",), ("--speed-factor=1",)], ids=["fast", "real time"])
def test_same_seeds_give_the_same_flight_to_the_last_bit(
    noisy: Ended, speed: tuple[str, ...]
) -> None:
    again = fly(*speed, *NOISY, timeout_s=240.0)
    assert len(trace(noisy)) > 500
    assert trace(again) == trace(noisy)
    assert commands(again) == commands(noisy)
    assert gates(again) == gates(noisy)
    assert again.result["duration_s"] == noisy.result["duration_s"]
    assert again.result["gates_passed"] == noisy.result["gates_passed"]


def test_flies_without_lockstep_over_the_ground_stations_link(tmp_path: Path) -> None:
    with free_instance() as instance:
        port = GROUND_STATION_PORT + instance
        links = (f"--instance={instance}", f"--gcs-link={18570 + instance}:{port}")
        options = ("--noise=0,0", f"--speed-factor={FREE_SPEED_FACTOR}")
        with process("sitl", *links, *options, log=tmp_path / "vehicle.txt"):
            log = f"--log={tmp_path / 'flight.tlog'}"
            flown = run_module(
                *("flightstack.companion", f"--udp={port}", "--json", log), timeout_s=120.0
            )
    assert flown.code == 0, flown.stderr
    assert flown.result["gates_passed"] == 8
    assert flown.result["setpoints"] >= 0.98 * flown.result["frames"]
