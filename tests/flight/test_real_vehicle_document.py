"""Every command of docs/real-vehicle.md, in the order of the page, against the simulator."""

import contextlib
import os
import re
import selectors
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from scripts.fly_course import API_PORT, free_instance
from tests.flight.bare_vehicle import (
    GROUND_STATION_PORTS,
    SerialLine,
    autopilot_only,
    bare_vehicle,
    indoors,
)
from tests.flight.processes import ENVIRONMENT, ROOT

pytestmark = pytest.mark.flight
DOCUMENT = ROOT / "docs" / "real-vehicle.md"
COMMANDS = [
    line
    for block in re.findall(r"```sh\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    for line in block.splitlines()
]
SPEED = "--speed-factor=3"
FLIGHT_S = 120.0  # wall time
WAITING = "waiting until the vehicle can be armed"
# By the name of the log: the exit code, and what the companion says.
ENDINGS = {
    "rehearsal": (1, "ended by its time limit"),
    "fence": (1, "taken over"),
    "bench": (130, "done (interrupted)"),
    "signed": (1, "ended by its time limit"),
    "first": (0, "completed"),
    "ethernet": (0, "completed"),
}


class FlightDay:
    """A folder with logs and keys, and the vehicle that stands there at the moment."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._vehicle = contextlib.ExitStack()
        self._substitutes: dict[str, str] = {}

    def run(self, command: str) -> None:
        if "-m sitl" in command:
            self._start_vehicle(command)
        elif "-m flightstack.companion" in command:
            self._fly(command)
        else:
            with _ended(self._shell(command, subprocess.PIPE)) as shell:
                said = shell.communicate(timeout=60)[0].decode()
            assert shell.returncode == 0, said

    def end_vehicle(self) -> None:
        self._vehicle.close()

    def _start_vehicle(self, command: str) -> None:
        self.end_vehicle()
        instance = self._vehicle.enter_context(free_instance())
        local, remote = (port + instance for port in GROUND_STATION_PORTS)
        place = (f"--instance={instance}", f"--gcs-link={local}:{remote}", "--noise=0,0", SPEED)
        vehicle = self._shell(" ".join((command, *place)), subprocess.DEVNULL)
        self._vehicle.enter_context(_ended(vehicle))
        self._substitutes = {"14540": str(API_PORT + instance)}

    def _meet_vehicle(self, command: str) -> None:
        """Have the simulator stand where the command expects a real vehicle."""
        self.end_vehicle()
        signing = re.findall(r"--signing-key (\S+)", command)
        options = [f"--signing-key={self.folder / key}" for key in signing]
        place = indoors if "logs/bench" in command else autopilot_only
        met = self._vehicle.enter_context(bare_vehicle(self.folder, SPEED, *options, place=place))
        self._substitutes = {"14540": str(met.port)}
        if "/dev/ttyACM0" in command:
            line = self._vehicle.enter_context(SerialLine(met.port))
            self._substitutes["/dev/ttyACM0"] = line.device
        camera = re.findall(r"--camera (\S+)", command)[0]
        self._substitutes[f"--camera {camera}"] = f"--camera {met.camera}"

    def _fly(self, command: str) -> None:
        if "--camera" in command:
            self._meet_vehicle(command)
        name = re.findall(r"--log logs/(\w+)\.tlog", command)[0]
        code, words = ENDINGS[name]
        with _ended(self._shell(command, subprocess.PIPE)) as companion:
            said = ""
            if name == "bench":
                said = _read_until(companion, WAITING)
                self._wait_for_pictures(name, 100)
                companion.send_signal(signal.SIGINT)
            said += companion.communicate(timeout=FLIGHT_S)[0].decode()
        assert companion.returncode == code, said
        assert words in said
        assert ("arming" in said) == (name != "bench")
        assert (self.folder / "logs" / f"{name}.tlog").stat().st_size > 10_000
        recorded = "--record-frames" in command
        assert (self.folder / "logs" / f"{name}.frames").exists() == recorded

    def _wait_for_pictures(self, name: str, count: int) -> None:
        folder = self.folder / "logs" / f"{name}.frames"
        deadline_s = time.monotonic() + FLIGHT_S
        while len(list(folder.glob("*.png"))) < count:
            assert time.monotonic() < deadline_s
            time.sleep(0.1)

    def _shell(self, command: str, output: int) -> subprocess.Popen[bytes]:
        for written, meant in self._substitutes.items():
            command = command.replace(written, meant)
        command = command.replace("python -m", f"exec {shlex.quote(sys.executable)} -m")
        return subprocess.Popen(
            ["/bin/bash", "-euo", "pipefail", "-c", command],
            cwd=self.folder,
            env=ENVIRONMENT | {"PYTHONPATH": str(ROOT)},
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT if output == subprocess.PIPE else output,
        )


def _read_until(running: subprocess.Popen[bytes], text: str) -> str:
    assert running.stdout is not None
    said = ""
    deadline_s = time.monotonic() + FLIGHT_S
    with selectors.DefaultSelector() as selector:
        selector.register(running.stdout, selectors.EVENT_READ)
        while text not in said:
            left_s = deadline_s - time.monotonic()
            assert left_s > 0.0, f"no {text!r} in {said!r}"
            if selector.select(left_s):
                chunk = os.read(running.stdout.fileno(), 65536)
                assert chunk, f"ended before {text!r}: {said!r}"
                said += chunk.decode()
    return said


@contextlib.contextmanager
def _ended(running: subprocess.Popen[bytes]) -> Iterator[subprocess.Popen[bytes]]:
    """Terminate, then kill, on the way out."""
    with running:
        try:
            yield running
        finally:
            running.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                running.wait(10.0)
            running.kill()


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FlightDay]:
    flight_day = FlightDay(tmp_path_factory.mktemp("day"))
    yield flight_day
    flight_day.end_vehicle()


@pytest.mark.parametrize("command", COMMANDS)
def test_command_does_what_the_page_says(command: str, day: FlightDay) -> None:
    day.run(command)


def test_no_flight_of_the_page_is_left_out() -> None:
    flown = {name for command in COMMANDS for name in re.findall(r"--log logs/(\w+)", command)}
    assert flown == set(ENDINGS)
