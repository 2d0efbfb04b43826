"""Logs survive the death of whoever writes them: every complete record is read back."""

import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from flightstack.launch.instances import free_instance
from flightstack.logs import read_bytes
from tests.flight.processes import pair, process

pytestmark = pytest.mark.flight
PATIENCE_S = 60.0
KILLS = int(os.environ.get("FLIGHTSTACK_KILLS", "3"))  # of each process; 25 make a thorough run


def complete_records(data: bytes) -> int:
    """Walk the file record by record and count those that are whole; MAVLink 2 only."""
    at = count = 0
    while at + 8 + 12 <= len(data):
        assert data[at + 8] == 0xFD
        at += 8 + 12 + data[at + 9] + (13 if data[at + 10] & 1 else 0)
        count += at <= len(data)
    return count


def assert_reads_back(path: Path) -> int:
    data = path.read_bytes() if path.exists() else b""
    log = read_bytes(data)
    assert len(log) == complete_records(data)
    assert [region.kind for region in log.damage.regions] in ([], ["cut"])
    return len(log)


@pytest.mark.parametrize("seed", range(KILLS))
def test_a_killed_vehicle_leaves_every_complete_record(seed: int, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.tlog"
    with free_instance() as instance:
        options = (f"--instance={instance}", "--speed-factor=5", f"--log={path}")
        with process("sitl", *options, log=tmp_path / "vehicle.txt") as vehicle:
            while not path.exists() or not path.stat().st_size:
                assert vehicle.poll() is None
                time.sleep(0.05)
            time.sleep(np.random.default_rng(seed).uniform(0.0, 2.0))
            vehicle.send_signal(signal.SIGKILL)
            vehicle.wait()
    assert assert_reads_back(path) > 0


@pytest.mark.parametrize("seed", range(KILLS))
def test_a_killed_companion_leaves_every_complete_record(seed: int, tmp_path: Path) -> None:
    with pair(tmp_path) as flight:
        deadline_s = time.monotonic() + PATIENCE_S
        while not flight.companion_log.exists() or not flight.companion_log.stat().st_size:
            assert flight.companion.poll() is None, flight.companion_output.read_text()
            assert time.monotonic() < deadline_s
            time.sleep(0.05)
        time.sleep(np.random.default_rng(seed).uniform(0.0, 2.0))
        flight.companion.send_signal(signal.SIGKILL)
        flight.companion.wait()
        flight.vehicle.send_signal(signal.SIGKILL)
        flight.vehicle.wait()
    assert assert_reads_back(flight.companion_log) > 0
    assert assert_reads_back(flight.vehicle_log) >= 0
