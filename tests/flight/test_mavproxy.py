"""MAVProxy, as a person uses it: parameters, arm, take off, land."""

import os
import selectors
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.fly_course import API_PORT, free_instance
from tests.flight.processes import ENVIRONMENT, process

pytestmark = pytest.mark.flight
MODULES = "link,param,arm,cmdlong"
TAKEOFF_AMSL_M = 493  # home is at 489.4 m


class Console:
    """Type commands, and read until an answer stands on the screen."""

    def __init__(self, running: subprocess.Popen[bytes]) -> None:
        self._process = running
        self._screen = ""

    def type(self, line: str) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()

    def expect(self, text: str, *, timeout_s: float) -> None:
        """Read on until `text` has come; what stands before it is done with."""
        assert self._process.stdout is not None
        deadline_s = time.monotonic() + timeout_s
        with selectors.DefaultSelector() as selector:
            selector.register(self._process.stdout, selectors.EVENT_READ)
            while text not in self._screen:
                left_s = deadline_s - time.monotonic()
                assert left_s > 0.0, f"no {text!r} within {timeout_s:g} s:\n{self._screen}"
                if selector.select(left_s):
                    chunk = os.read(self._process.stdout.fileno(), 65536)
                    assert chunk, f"ended before {text!r}:\n{self._screen}"
                    self._screen += chunk.decode(errors="replace")
        self._screen = self._screen.partition(text)[2]


@pytest.fixture
def console(tmp_path: Path) -> Iterator[Console]:
    mavproxy = Path(sys.executable).with_name("mavproxy.py")
    with free_instance() as instance:
        options = (f"--instance={instance}", "--noise=0,0", "--speed-factor=5")
        with (
            process("sitl", *options, log=tmp_path / "vehicle.txt"),
            subprocess.Popen(
                [
                    *(sys.executable, "-u", str(mavproxy), f"--default-modules={MODULES}"),
                    *(f"--master=udpin:127.0.0.1:{API_PORT + instance}",),
                    *(f"--state-basedir={tmp_path}",),
                ],
                cwd=tmp_path,
                env=ENVIRONMENT,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            ) as running,
        ):
            try:
                yield Console(running)
            finally:
                running.kill()


def test_a_person_takes_off_and_lands(console: Console) -> None:
    console.expect("online system", timeout_s=20.0)
    console.expect("Received", timeout_s=20.0)  # ... parameters
    console.type("param show MPC_XY_VEL_MAX")
    console.expect("MPC_XY_VEL_MAX   12.0", timeout_s=5.0)
    console.type("arm throttle")
    console.expect("ARMED", timeout_s=5.0)
    console.type(f"long NAV_TAKEOFF 0 0 0 0 nan nan {TAKEOFF_AMSL_M}")
    console.expect("Mode TAKEOFF", timeout_s=5.0)
    console.expect("Mode LOITER", timeout_s=15.0)
    console.type("long DO_SET_MODE 1 4 6")
    console.expect("Mode LAND", timeout_s=5.0)
    console.expect("DISARMED", timeout_s=20.0)
