"""A real PX4, where FLIGHTSTACK_PX4 names its build folder or its binary; else nothing is tried."""

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest

from flightstack.launch import fly
from tests.flight.processes import ENVIRONMENT
from tests.flight.test_fly import FLY, assert_gone, children

BUILD = os.environ.get("FLIGHTSTACK_PX4")
pytestmark = [
    pytest.mark.flight,
    pytest.mark.skipif(BUILD is None, reason="FLIGHTSTACK_PX4 names no build of PX4"),
]


def test_a_course_is_flown_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = fly(track_seed=1000, noise=(0.0, 0.0), fast=True, px4=Path(str(BUILD)))
    assert (result.outcome, result.gates_passed, result.gates_total) == ("completed", 8, 8)
    assert result.log.is_file()


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_px4_never_outlives_the_command(tmp_path: Path, ending: signal.Signals) -> None:
    flight = subprocess.Popen(
        [*FLY, "--fast", "--laps=9", "--autopilot=px4", f"--px4={BUILD}", "--px4-folder=px4"],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert flight.stderr is not None
    for line in flight.stderr:
        if "gate 1/" in line:
            break
    started = children(flight.pid)
    assert len(started) == 3
    flight.send_signal(ending)
    flight.communicate(timeout=60.0)
    assert_gone(started)
    assert list((tmp_path / "px4").glob("log/**/*.ulg"))


def test_a_px4_that_dies_in_flight_leaves_a_result(tmp_path: Path) -> None:
    flight = subprocess.Popen(
        [*FLY, "--fast", "--json", "--noise=0,0", "--autopilot=px4", f"--px4={BUILD}"],
        cwd=tmp_path,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert flight.stderr is not None
    for line in flight.stderr:
        if "gate 1/" in line:
            break
    started = children(flight.pid)
    (px4,) = (pid for pid in started if Path(f"/proc/{pid}/exe").resolve().name == "px4")
    os.kill(px4, signal.SIGKILL)
    printed, said = flight.communicate(timeout=60.0)
    assert json.loads(printed.splitlines()[-1])["outcome"] == "link_lost"
    assert "PX4 ended with -9" in said
    assert_gone(started)


def test_two_fly_at_once(tmp_path: Path) -> None:
    command = [*FLY, "--fast", "--noise=0,0", "--autopilot=px4", f"--px4={BUILD}"]
    pair = [
        subprocess.Popen(command, cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.DEVNULL)
        for _ in range(2)
    ]
    assert [flight.wait(200.0) for flight in pair] == [0, 0]


def test_it_is_ended_in_order_after_landing(tmp_path: Path) -> None:
    command = [*FLY, "--fast", "--noise=0,0", "--autopilot=px4", f"--px4={BUILD}"]
    subprocess.run(
        [*command, "--px4-folder=px4"], cwd=tmp_path, env=ENVIRONMENT, check=True, timeout=200.0
    )
    said = (tmp_path / "px4" / "px4.out").read_text()
    assert "Disarmed by landing" in said
    assert "PX4 Exiting..." in said
