"""Start vehicles and companions as real processes, and end them whatever happens."""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flightstack.launch.instances import API_PORT, free_instance
from flightstack.launch.processes import Process, running
from flightstack.launch.processes import module as launched
from tests.paths import ROOT

ENVIRONMENT = {"OMP_NUM_THREADS": "1"} | os.environ
FAST = ("--speed-factor", "0")  # as fast as possible
LOCKSTEP = ("--lockstep", *FAST)
ENDS_S = 10.0
VEHICLES = ("sitl", "tests.wire.offboard.draggy_vehicle")


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """A vehicle and the companion that flies it."""

    instance: int
    vehicle: Process
    companion: Process
    vehicle_log: Path  # tlog of all the vehicle's links
    companion_log: Path  # tlog of the companion's link
    companion_output: Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """What a finished process leaves behind."""

    code: int
    stdout: str
    stderr: str

    @property
    def result(self) -> dict[str, Any]:
        """The JSON object in the last line of output."""
        fields: dict[str, Any] = json.loads(self.stdout.splitlines()[-1])
        return fields


def run(command: list[str], *, timeout_s: float, cwd: Path = ROOT) -> Ended:
    """Run to the end; a process that outlives the deadline is killed and fails the test."""
    finished = subprocess.run(
        command,
        cwd=cwd,
        env=ENVIRONMENT | {"PYTHONPATH": str(ROOT)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    return Ended(code=finished.returncode, stdout=finished.stdout, stderr=finished.stderr)


def run_module(module: str, *options: str, timeout_s: float = 60.0) -> Ended:
    """Run `python -m module` to its end."""
    return run([sys.executable, "-m", module, *options], timeout_s=timeout_s)


@contextlib.contextmanager
def process(module: str, *options: str, log: Path) -> Iterator[Process]:
    """Start `python -m module`, both outputs into `log`; it ends on the way out."""
    soon = ("--ready-after=1",) if module in VEHICLES else ()  # the options go before that
    with log.open("wb") as output:
        program = launched(module, [*soon, *options], output, subprocess.STDOUT)
        with running(replace(program, folder=ROOT), ends_s=ENDS_S) as started:
            yield started


@contextlib.contextmanager
def pair(folder: Path, *vehicle_options: str, companion: Sequence[str] = ()) -> Iterator[Pair]:
    """Start both in lockstep, as fast as they can, on an instance of their own."""
    vehicle_log, companion_log = folder / "vehicle.tlog", folder / "companion.tlog"
    output = folder / "companion.txt"
    with contextlib.ExitStack() as stack:
        instance = stack.enter_context(free_instance())
        vehicle_options = (*LOCKSTEP, *vehicle_options, f"--instance={instance}")
        companion_options = (f"--udp={API_PORT + instance}", f"--log={companion_log}", *companion)
        start = stack.enter_context
        yield Pair(
            instance=instance,
            vehicle=start(
                process(
                    *("sitl", *vehicle_options, f"--log={vehicle_log}"), log=folder / "vehicle.txt"
                )
            ),
            companion=start(process("flightstack.companion", *companion_options, log=output)),
            vehicle_log=vehicle_log,
            companion_log=companion_log,
            companion_output=output,
        )
