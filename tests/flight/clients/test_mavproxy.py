"""MAVProxy, as a person uses it: parameters, arm, take off, land; missions from files."""

import os
import selectors
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from flightstack.launch.instances import API_PORT, free_instance
from tests.flight.processes import ENVIRONMENT, process

pytestmark = pytest.mark.flight
MODULES = "link,param,arm,cmdlong,wp,fence,rally"
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


# index, current, frame, command, four parameters, latitude, longitude, altitude, autocontinue
PLANS = {
    "wp": """0 1 0 16 0 0 0 0 47.397742 8.545594 489.4 1
1 0 3 22 0 0 0 0 47.397742 8.545594 5 1
2 0 3 16 0 2 0 0 47.397792 8.545594 5 1
3 0 3 20 0 0 0 0 0 0 0 1""",
    "fence": "0 0 3 5003 60 0 0 0 47.397742 8.545594 0 1",
    "rally": "0 0 3 5100 0 0 0 0 47.397842 8.545594 10 1",
}
KINDS = {"wp": "MISSION", "fence": "FENCE", "rally": "RALLY"}
LISTED = {
    "wp": "16 3 47.3977920000 8.5455940000 5.000000 p1=0.0 p2=2.0",
    "fence": "5003 3 47.3977420000 8.5455940000 0.000000 p1=60.0",
    "rally": "5100 3 47.3978420000 8.5455940000 10.000000",
}


def test_a_person_loads_a_mission_from_a_file_and_flies_it(
    console: Console, tmp_path: Path
) -> None:
    console.expect("online system", timeout_s=20.0)
    console.expect("Received", timeout_s=20.0)
    for module, lines in PLANS.items():
        plan = tmp_path / f"{module}.txt"
        plan.write_text("QGC WPL 110\n" + lines.replace(" ", "\t") + "\n")
        console.type(f"{module} load {plan}")
        console.expect(f"Got MISSION_ACK: TYPE_{KINDS[module]}: ACCEPTED", timeout_s=5.0)
        console.type(f"{module} list")
        console.expect(LISTED[module], timeout_s=5.0)
    console.type("long DO_SET_MODE 1 4 4")
    console.expect("Mode MISSION", timeout_s=5.0)
    console.type("arm throttle")
    console.expect("ARMED", timeout_s=5.0)
    console.expect("Mode RTL", timeout_s=20.0)
    console.expect("DISARMED", timeout_s=30.0)
