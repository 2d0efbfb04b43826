"""The one command leaves nothing behind, whatever ends it."""

import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.flight.processes import ENVIRONMENT, run
from tests.paths import ROOT

pytestmark = pytest.mark.flight
FLY = [sys.executable, str(ROOT / "scripts" / "fly_course.py")]
GONE_S = 10.0


def start_in_flight(log: Path) -> subprocess.Popen[str]:
    """Start a long flight and return when it has passed its first gate."""
    log.touch()
    flight = subprocess.Popen(
        [*FLY, "--fast", "--noise=0,0", "--laps=9"],
        cwd=log.parent,
        env=ENVIRONMENT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert flight.stderr is not None
    lines = []
    for line in flight.stderr:
        lines.append(line)
        if "gate 1/" in line:
            return flight
    raise AssertionError("".join(lines))


def children(pid: int) -> list[int]:
    listing = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in listing.split()]


def assert_gone(pids: list[int]) -> None:
    deadline_s = time.monotonic() + GONE_S
    for pid in pids:
        try:
            descriptor = os.pidfd_open(pid)
        except ProcessLookupError:
            continue
        gone, _, _ = select.select([descriptor], [], [], max(0.0, deadline_s - time.monotonic()))
        os.close(descriptor)
        assert gone, f"process {pid} outlived the flight"


@pytest.mark.parametrize(
    ("ending", "code"),
    [(signal.SIGINT, 130), (signal.SIGTERM, 130), (signal.SIGKILL, -signal.SIGKILL)],
)
def test_no_process_outlives_the_flight(tmp_path: Path, ending: signal.Signals, code: int) -> None:
    flight = start_in_flight(tmp_path / "log")
    started = children(flight.pid)
    assert len(started) == 2
    flight.send_signal(ending)
    _, errors = flight.communicate(timeout=60.0)
    assert flight.returncode == code
    assert_gone(started)
    if ending is not signal.SIGKILL:  # then both are told to end at once, and land in vain
        assert "landing (interrupted)" in errors


def test_two_flights_run_side_by_side(tmp_path: Path) -> None:
    flight = start_in_flight(tmp_path / "log")
    try:
        second = run([*FLY, "--fast", "--noise=0,0", "--json"], timeout_s=120.0)
        assert second.code == 0, second.stderr
        assert second.result["gates_passed"] == 8
        assert flight.poll() is None
    finally:
        flight.send_signal(signal.SIGINT)
        flight.communicate(timeout=60.0)
