"""SIGKILL at random moments: whatever the companion had written whole is read back, in order."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from multiprocessing.context import ForkProcess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.console import Console
from flightstack.companion.flight import fly
from flightstack.companion.opening.steps import FlightPlan
from flightstack.logs import read
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.mavlink.tlog import TlogWriter
from tests.wire.companion.companion_trial import free_port, guarded
from tests.wire.fake_vehicle import FakeVehicle, Script

pytestmark = pytest.mark.flight
FORK = multiprocessing.get_context("fork")
WRITER_KILLS, FLIGHT_KILLS = 25, 10
LATEST_S = 0.05  # of a writer at full speed: some ten thousand records
LATEST_IN_FLIGHT_S = 1.0
WAIT_S = 20.0
RECORD_BYTES = 8 + 12 + 12  # time, packet without payload, SYSTEM_TIME whose last byte is not 0


def write_until_killed(path: Path, flushed: Any) -> None:
    """Write numbered records as fast as can be; `flushed` counts those handed to the system."""
    protocol = common.MAVLink(None, 1, 191)
    log = TlogWriter(path)
    number = 0
    while True:
        for _ in range(500):
            message = common.MAVLink_system_time_message(number, 1 << 31)
            log.append(number, bytes(message.pack(protocol)))
            number += 1
        log.flush()
        flushed.value = number


def wait_until(condition: Callable[[], bool]) -> None:
    deadline_s = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < deadline_s
        time.sleep(0.001)


def kill(process: ForkProcess) -> None:
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    process.join(WAIT_S)
    assert process.exitcode == -signal.SIGKILL


@pytest.mark.parametrize("seed", range(WRITER_KILLS))
def test_a_killed_writer_leaves_every_record_that_it_had_written(seed: int, tmp_path: Path) -> None:
    path = tmp_path / "a.tlog"
    flushed = FORK.Value("L", 0)
    writer = FORK.Process(target=write_until_killed, args=(path, flushed), daemon=True)
    writer.start()
    wait_until(lambda: flushed.value > 0)
    time.sleep(np.random.default_rng(seed).uniform(0.0, LATEST_S))
    kill(writer)
    numbers = read(path)["SYSTEM_TIME"]["time_unix_usec"]
    assert len(numbers) >= flushed.value
    np.testing.assert_array_equal(numbers, np.arange(len(numbers)))
    assert path.stat().st_size - len(numbers) * RECORD_BYTES < RECORD_BYTES


@pytest.mark.parametrize("seed", range(FLIGHT_KILLS))
def test_a_killed_flight_leaves_all_but_its_last_moment(seed: int, tmp_path: Path) -> None:
    path, port = tmp_path / "flight.tlog", free_port()
    plan = FlightPlan(endpoint=parse_endpoint(f"udpin:127.0.0.1:{port}"), log=path)
    companion = FORK.Process(target=fly, args=(plan, guarded, Console(verbosity=-1)), daemon=True)
    companion.start()
    with FakeVehicle(port, Script(gates=None)) as vehicle:
        wait_until(lambda: path.exists() and path.stat().st_size > 0)
        time.sleep(np.random.default_rng(seed).uniform(0.0, LATEST_IN_FLIGHT_S))
        kill(companion)
        heard = [setpoint.time_boot_ms for setpoint in vehicle.setpoints()]
    log = read(path)
    kept = log["SET_POSITION_TARGET_LOCAL_NED"]["time_boot_ms"].tolist()
    assert kept
    assert kept == heard[: len(kept)]
    assert [region.kind for region in log.damage.regions] in ([], ["cut"])
