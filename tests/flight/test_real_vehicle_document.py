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

from flightstack.launch.instances import API_PORT, free_instance
from flightstack.launch.processes import Process, Program, running
from tests.flight.bare_vehicle import (
    GROUND_STATION_PORTS,
    SerialLine,
    autopilot_only,
    bare_vehicle,
    indoors,
)
from tests.flight.processes import ENDS_S, ENVIRONMENT, Ended
from tests.paths import ROOT

pytestmark = pytest.mark.flight
DOCUMENT = ROOT / "docs" / "real-vehicle.md"
COMMANDS = [
    line
    for block in re.findall(r"```sh\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
    for line in block.splitlines()
]
SPEED = "--speed-factor=3"
FLIGHT_S = 120.0  # wall time
UP = "/stream"  # the vehicle's first line ends with where its camera is
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

    def run(self, command: str) -> Ended:
        """What came of a command; of a vehicle, which flies on: that it has come up."""
        if "-m sitl" in command:
            return self._start_vehicle(command)
        if "-m flightstack.companion" in command:
            return self._fly(command)
        with running(self._shell(command, subprocess.PIPE), ends_s=ENDS_S) as shell:
            said = shell.communicate(timeout=60)[0].decode()
        return Ended(code=shell.returncode, stdout=said, stderr="")

    def end_vehicle(self) -> None:
        self._vehicle.close()

    def _start_vehicle(self, command: str) -> Ended:
        self.end_vehicle()
        instance = self._vehicle.enter_context(free_instance())
        local, remote = (port + instance for port in GROUND_STATION_PORTS)
        place = (f"--instance={instance}", f"--gcs-link={local}:{remote}", "--noise=0,0", SPEED)
        output = self.folder / "simulator.txt"
        program = self._shell(f"{' '.join((command, *place))} 2> {output}", subprocess.DEVNULL)
        vehicle = self._vehicle.enter_context(running(program, ends_s=ENDS_S))
        self._substitutes = {"14540": str(API_PORT + instance)}
        deadline_s = time.monotonic() + FLIGHT_S
        while not output.exists() or UP not in output.read_text():
            assert vehicle.poll() is None, command
            assert time.monotonic() < deadline_s
            time.sleep(0.1)
        return Ended(code=0, stdout=output.read_text(), stderr="")

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

    def _fly(self, command: str) -> Ended:
        if "--camera" in command:
            self._meet_vehicle(command)
        name = name_of(command)
        with running(self._shell(command, subprocess.PIPE), ends_s=ENDS_S) as companion:
            said = ""
            if name == "bench":
                said = _read_until(companion, WAITING)
                self._wait_for_pictures(name, 100)
                companion.send_signal(signal.SIGINT)
            said += companion.communicate(timeout=FLIGHT_S)[0].decode()
        return Ended(code=companion.returncode, stdout=said, stderr="")

    def _wait_for_pictures(self, name: str, count: int) -> None:
        folder = self.folder / "logs" / f"{name}.frames"
        deadline_s = time.monotonic() + FLIGHT_S
        while len(list(folder.glob("*.png"))) < count:
            assert time.monotonic() < deadline_s
            time.sleep(0.1)

    def _shell(self, command: str, output: int) -> Program:
        for written, meant in self._substitutes.items():
            command = command.replace(written, meant)
        command = command.replace("python -m", f"exec {shlex.quote(sys.executable)} -m")
        return Program(
            command=["/bin/bash", "-euo", "pipefail", "-c", command],
            stdout=output,
            stderr=subprocess.STDOUT if output == subprocess.PIPE else output,
            environment=ENVIRONMENT | {"PYTHONPATH": str(ROOT)},
            folder=self.folder,
        )


def name_of(command: str) -> str:
    """The name of a flight's log."""
    return str(re.findall(r"--log logs/(\w+)\.tlog", command)[0])


def _read_until(process: Process, text: str) -> str:
    assert process.stdout is not None
    said = ""
    deadline_s = time.monotonic() + FLIGHT_S
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while text not in said:
            left_s = deadline_s - time.monotonic()
            assert left_s > 0.0, f"no {text!r} in {said!r}"
            if selector.select(left_s):
                chunk = os.read(process.stdout.fileno(), 65536)
                assert chunk, f"ended before {text!r}: {said!r}"
                said += chunk.decode()
    return said


@pytest.fixture(scope="module")
def day(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FlightDay]:
    flight_day = FlightDay(tmp_path_factory.mktemp("day"))
    yield flight_day
    flight_day.end_vehicle()


@pytest.mark.parametrize("command", COMMANDS)
def test_command_does_what_the_page_says(command: str, day: FlightDay) -> None:
    came = day.run(command)
    if "-m flightstack.companion" not in command:
        assert came.code == 0, came.stdout
        return
    name = name_of(command)
    code, words = ENDINGS[name]
    assert came.code == code, came.stdout
    assert words in came.stdout
    assert ("arming" in came.stdout) == (name != "bench")
    assert (day.folder / "logs" / f"{name}.tlog").stat().st_size > 10_000
    recorded = "--record-frames" in command
    assert (day.folder / "logs" / f"{name}.frames").exists() == recorded


def test_no_flight_of_the_page_is_left_out() -> None:
    flown = {name for command in COMMANDS for name in re.findall(r"--log logs/(\w+)", command)}
    assert flown == set(ENDINGS)
