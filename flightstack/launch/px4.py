"""A real PX4 for a flight: where its build is, what it is told, and the folder that it runs in.

It is built or unpacked by the user, and started in an empty folder, since it keeps parameters,
missions and logs where it runs.
"""

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from flightstack.errors import UsageError
from flightstack.launch.instances import free_instance
from flightstack.launch.order import last_line
from flightstack.launch.ports import Ports
from flightstack.launch.processes import Pair, Program, environment
from flightstack.launch.request import FlightRequest

OUTPUT = "px4.out"  # what it prints, in its folder
WALL_CLOCK = "PX4_SIM_SPEED_FACTOR"  # stretches timeouts, for clients that live in wall time


@dataclass(frozen=True, slots=True, kw_only=True)
class Px4:
    """One PX4 that is to be started, or runs."""

    program: Program
    folder: Path

    def explain_end(self, pair: Pair) -> str | None:
        """Say how it ended, in its own last words; None while it runs."""
        code = None if pair.px4 is None else pair.px4.poll()
        if code is None:
            return None
        words = last_line((self.folder / OUTPUT).read_text(errors="replace"))
        return f"PX4 ended with {code}: {words}"


@contextlib.contextmanager
def held_ports(request: FlightRequest) -> Iterator[Ports]:
    """Hold the ports of a free instance; raises LinkError where there is none."""
    real_px4 = request.px4 is not None
    with free_instance(real_px4=real_px4) as instance:
        yield (Ports.of_px4_instance if real_px4 else Ports.of_instance)(instance)


@contextlib.contextmanager
def prepared_px4(request: FlightRequest, ports: Ports) -> Iterator[Px4 | None]:
    """Prepare the PX4 of a flight, with its folder; None where the emulated autopilot flies.

    Raises UsageError where there is no PX4, or the folder holds something.
    """
    if request.px4 is None:
        yield None
        return
    binary, etc = _find(request.px4)
    with contextlib.ExitStack() as stack:
        folder = request.px4_folder
        if folder is None:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="px4-")))
        else:
            _make_empty(folder)
        output = stack.enter_context((folder / OUTPUT).open("wb"))
        program = Program(
            command=[str(binary), "-i", str(ports.instance), "-d", str(etc)],
            stdout=output,
            stderr=output,
            environment=_environment(request, ports),
            folder=folder,
            orphan_signal=signal.SIGKILL,  # without a simulator it would spin for ever
        )
        yield Px4(program=program, folder=folder)


def _find(path: Path) -> tuple[Path, Path]:
    """Find binary and start scripts, `bin/px4` and `etc` of a build folder."""
    binary = path / "bin" / "px4" if path.is_dir() else path
    etc = binary.resolve().parent.parent / "etc"
    if not binary.is_file() or not os.access(binary, os.X_OK):
        raise UsageError(f"--px4 {path}: no PX4; name build/px4_sitl_default or its bin/px4")
    if not (etc / "init.d-posix" / "rcS").is_file():
        raise UsageError(
            f"--px4 {path}: no etc/init.d-posix/rcS beside its bin; build PX4 for sitl"
        )
    return binary.resolve(), etc


def _make_empty(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        is_empty = not any(folder.iterdir())
    except OSError as error:
        raise UsageError(f"--px4-folder {folder}: {error.strerror}") from None
    if not is_empty:
        raise UsageError(f"--px4-folder {folder}: is not empty; PX4 would take up what is there")


def _environment(request: FlightRequest, ports: Ports) -> Mapping[str, str]:
    """Ask the simulator what PX4 must know; parameters that the user has set go before it."""
    command = [sys.executable, "-m", "sitl", *request.vehicle_arguments(ports)]
    asked = subprocess.run(  # noqa: S603  our own program
        [*command, "--px4-environment"],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    if asked.returncode != 0:
        raise UsageError(last_line(asked.stderr))
    named = dict(line.split("=", 1) for line in asked.stdout.splitlines())
    own = {key: value for key, value in os.environ.items() if key.startswith("PX4_PARAM_")}
    return {k: v for k, v in os.environ.items() if k != WALL_CLOCK} | named | own
