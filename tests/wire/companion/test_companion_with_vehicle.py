"""The companion, with a pilot that only flies straight on, and the simulated vehicle's process."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil

from flightstack.companion.console import Console
from flightstack.companion.flight import fly
from flightstack.companion.mission.records import Outcome
from flightstack.companion.opening.steps import FlightPlan
from flightstack.companion.piloting.in_process import InProcessPilot
from flightstack.companion.summary import FlightSummary
from flightstack.launch.instances import API_PORT, free_instance
from flightstack.logs import read
from flightstack.logs.flight.course import find_gates
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.records import Decision, Image
from tests.wire.companion.companion_trial import ForwardPilot, read_tlog

pytestmark = pytest.mark.flight
OFFBOARD = 0x00060000


class Vehicle:
    def __init__(self, instance: int, *options: str) -> None:
        command = [sys.executable, "-m", "sitl", "--lockstep", f"--instance={instance}", "-q"]
        self.endpoint = parse_endpoint(str(API_PORT + instance))
        self.process = subprocess.Popen([*command, "--noise=0,0", *options])

    def fly(self, log: Path, pilot: ForwardPilot, **plan: Any) -> FlightSummary:
        flight = FlightPlan(endpoint=self.endpoint, log=log, timeout_s=30.0, **plan)
        return fly(flight, lambda _motion: InProcessPilot(pilot), Console(verbosity=-1))


@pytest.fixture
def instance() -> Iterator[int]:
    with free_instance() as free:
        yield free


def flown(instance: int, log: Path, *options: str, speed_factor: float = 0) -> FlightSummary:
    vehicle = Vehicle(instance, f"--speed-factor={speed_factor}", *options)
    try:
        return vehicle.fly(log, ForwardPilot((1.5, 0, 0, 0)), duration_s=4.0)
    finally:
        vehicle.process.terminate()
        vehicle.process.wait(10)


def positions(log: Path) -> list[tuple[float, ...]]:
    kind = "LOCAL_POSITION_NED"
    return [
        (m.time_boot_ms, m.x, m.y, m.z, m.vx, m.vy, m.vz)
        for m in read_tlog(log)
        if m.get_type() == kind
    ]


def test_takes_off_flies_lands_and_disarms(instance: int, tmp_path: Path) -> None:
    log = tmp_path / "flight.tlog"
    # A pilot that sees nothing passes a gate only where the vehicle knows exactly where it is.
    summary = flown(instance, log, "--perfect-estimate")
    assert summary.outcome in (Outcome.TIMEOUT, Outcome.MISSED_GATE)  # it flies straight on
    assert (summary.gates_passed, summary.gates_total) == (1, 8)
    assert summary.setpoints == summary.images
    beats = [m for m in read_tlog(log) if m.get_type() == "HEARTBEAT" and m.get_srcComponent() == 1]
    assert OFFBOARD in [beat.custom_mode for beat in beats]
    assert any(beat.base_mode & mavutil.mavlink.MAV_MODE_FLAG_SAFETY_ARMED for beat in beats)
    assert not beats[-1].base_mode & mavutil.mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert positions(log)[-1][3] == pytest.approx(0.0, abs=0.1)
    gates = find_gates(read(log))
    assert [gate.index for gate in gates] == list(range(8))
    assert gates[0].centre_ned == pytest.approx((4.7, 0.0, -3.0), abs=1e-3)


def test_the_same_flight_at_any_speed(instance: int, tmp_path: Path) -> None:
    tracks = []
    for name, speed_factor in (("fast", 0), ("again", 0), ("slow", 8)):
        log = tmp_path / f"{name}.tlog"
        flown(instance, log, speed_factor=speed_factor)
        tracks.append({row[0]: row for row in positions(log)})
    common = set.intersection(*map(set, tracks))
    assert len(common) > 300
    for stamp_ms in common:
        assert tracks[0][stamp_ms] == tracks[1][stamp_ms] == tracks[2][stamp_ms]


class KillingPilot(ForwardPilot):
    """Ends the vehicle's process after a second of flight."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        super().__init__()
        self._process = process

    def decide(self, image: Image) -> Decision:
        if len(self.images) == 20:
            os.kill(self._process.pid, signal.SIGKILL)
            self._process.wait()
        return super().decide(image)


def test_a_killed_vehicle_is_lost(instance: int, tmp_path: Path) -> None:
    vehicle = Vehicle(instance, "--speed-factor=0")
    log = tmp_path / "flight.tlog"
    try:
        summary = vehicle.fly(log, KillingPilot(vehicle.process), reach_s=4.0)
    finally:
        vehicle.process.kill()
        vehicle.process.wait(10)
    assert (summary.outcome, summary.exit_code) == (Outcome.LINK_LOST, 3)
    commands = [m.command for m in read_tlog(log) if m.get_type() == "COMMAND_LONG"]
    assert commands[-4:] == [mavutil.mavlink.MAV_CMD_NAV_LAND] * 4
