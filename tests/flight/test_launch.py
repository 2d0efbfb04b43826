"""A few lines of Python fly a course: the result as a record, errors in one line, nothing left."""

import contextlib
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flightstack.errors import ModelError, UsageError
from flightstack.launch import FlightResult, fly
from flightstack.launch.flight import fly_request
from flightstack.launch.request import FlightRequest
from flightstack.launch.warm import WarmStarter
from tests.flight.processes import ENVIRONMENT
from tests.flight.test_fly import assert_gone, children
from tests.paths import ROOT

pytestmark = pytest.mark.flight
START_S = 60.0
LONG_FLIGHT = "from flightstack.launch import fly; fly(laps=9, noise=(0.0, 0.0), fast=True)"


def timeless(result: FlightResult) -> tuple[object, ...]:
    return result.outcome, result.gates_passed, result.duration_s, result.frames, result.setpoints


def test_a_warm_start_gives_the_flight_of_a_cold_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cold = fly(track_seed=7, noise=(1.0, 2.0), fast=True)
    assert cold.outcome == "completed"
    assert (cold.gates_passed, cold.gates_total) == (8, 8)
    assert cold.log.is_file()
    request = FlightRequest(
        track_seed=7, noise="1.0,2.0", speed_factor=0.0, companion_options=("--json",)
    )
    with contextlib.closing(WarmStarter()) as warm:
        assert timeless(fly_request(request, warm)) == timeless(cold)


def test_a_course_is_flown_by_an_estimate_that_the_rotors_shake(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    request = FlightRequest(
        track_seed=3,
        noise="0.5,1.0",
        model="strong/b0",
        speed_factor=0.0,
        vehicle_options=("-q", "--condition=estimate.rotor_noise_share=1.0"),
        companion_options=("-q", "--json"),
    )
    result = fly_request(request)
    assert (result.outcome, result.gates_passed) == ("completed", 8)


def test_the_readmes_example_flies(tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    environment = ENVIRONMENT | {"PYTHONPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-c", blocks[0]],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    result, log = ran.stdout.splitlines()
    assert result == "completed: 8 gates of 8"
    assert (tmp_path / log.rpartition(": ")[2]).is_file()


def test_what_cannot_be_flown_is_one_line() -> None:
    with pytest.raises(ModelError, match=r"^flightstack\.companion: unknown model 'no/such'"):
        fly(model="no/such")
    with pytest.raises(UsageError, match=r"^sitl: argument --noise: "):
        fly(noise=(-1.0, 2.0))


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGKILL])
def test_no_process_outlives_the_call(tmp_path: Path, ending: signal.Signals) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", LONG_FLIGHT],
        cwd=tmp_path,
        env=ENVIRONMENT | {"PYTHONPATH": str(ROOT)},
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as script:
        deadline_s = time.monotonic() + START_S
        while not list(tmp_path.glob("logs/*.tlog")):
            assert script.poll() is None
            assert time.monotonic() < deadline_s
            time.sleep(0.05)
        started = children(script.pid)
        assert len(started) == 2
        script.send_signal(ending)
        _, said = script.communicate(timeout=30.0)
    assert script.returncode == -ending
    assert ending is signal.SIGKILL or said.rstrip().endswith("KeyboardInterrupt")
    assert_gone(started)
