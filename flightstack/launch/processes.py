"""Run processes that end with whoever started them, whatever happens: one, or all of a flight."""

import contextlib
import ctypes
import functools
import os
import selectors
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import IO, Any

from flightstack.launch.ports import Ports
from flightstack.launch.request import FlightRequest
from flightstack.libraries import require

COMPANION_NOTICES_S = 8.0  # a companion whose vehicle died ends by itself within 5 s
VEHICLE_ENDS_S = 5.0  # after SIGTERM: flush the log and leave
PX4_ENDS_S = 5.0  # likewise; it was seen to take 0.1 s
VEHICLE_REFUSED = (2, 3)  # exit codes of a vehicle that never started: usage, ports
PR_SET_PDEATHSIG = 1  # Linux prctl
LIBC = ctypes.CDLL(None)  # here: a child between fork and exec may load nothing
Process = subprocess.Popen[bytes]
Stream = IO[Any] | int | None
Outputs = tuple[Stream, Stream]  # standard output and error
OURS: Outputs = (None, None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Program:
    """A command, and where what it prints goes."""

    command: Sequence[str]
    stdout: Stream = None  # None: the starter's own, as for the next two
    stderr: Stream = None
    environment: Mapping[str, str] | None = None  # None: as `environment` makes it
    folder: Path | None = None
    orphan_signal: int = signal.SIGTERM  # what ends it when the starter is killed outright


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """The processes of a flight, each the leader of its own group."""

    vehicle: Process
    companion: Process
    px4: Process | None = None  # a real one, which the vehicle's process is the simulator of

    def pass_on(self, number: int, _: FrameType | None) -> None:
        """Hand a signal to the companion: it lands first, and at the second signal leaves."""
        if self.companion.poll() is None:
            self.companion.send_signal(number)

    def wait(self, limit_s: float | None = None) -> int:
        """Wait for the companion: its exit code, or that of a vehicle that refused to start."""
        with contextlib.ExitStack() as stack, selectors.DefaultSelector() as selector:
            for process in filter(None, (self.vehicle, self.companion, self.px4)):
                pidfd = os.pidfd_open(process.pid)
                stack.callback(os.close, pidfd)
                selector.register(pidfd, selectors.EVENT_READ)
            patience_s = limit_s  # endless without one, as long as both live
            while self.companion.poll() is None:
                events = selector.select(patience_s)
                if self.vehicle.poll() in VEHICLE_REFUSED:
                    return int(self.vehicle.returncode)
                if not events:
                    self.companion.terminate()
                for key, _ in events:
                    selector.unregister(key.fileobj)
                patience_s = COMPANION_NOTICES_S
            return self.companion.returncode


def module(
    name: str, arguments: Sequence[str], stdout: Stream = None, stderr: Stream = None
) -> Program:
    """Return `python -m name`."""
    command = [sys.executable, "-m", name, *arguments]
    return Program(command=command, stdout=stdout, stderr=stderr)


def programs(
    request: FlightRequest, ports: Ports, *, vehicle: Outputs = OURS, companion: Outputs = OURS
) -> tuple[Program, Program]:
    """Return the two that fly a course, and where what each prints goes.

    Raises MissingLibraryError where the simulator has not been installed.
    """
    require("sim", "pybullet")
    return (
        module("sitl", request.vehicle_arguments(ports), *vehicle),
        module("flightstack.companion", request.companion_arguments(ports), *companion),
    )


@contextlib.contextmanager
def started(vehicle: Program, companion: Program, px4: Program | None = None) -> Iterator[Pair]:
    """Start all; on any way out, end the companion at once, and the others with their logs whole.

    A real PX4 ends before its simulator, without which its clock would stand.
    """
    with contextlib.ExitStack() as stack:
        its_vehicle = stack.enter_context(running(vehicle, ends_s=VEHICLE_ENDS_S))
        its_px4 = None
        if px4 is not None:
            its_px4 = stack.enter_context(running(px4, ends_s=PX4_ENDS_S))
        its_companion = stack.enter_context(running(companion, ends_s=0.0))
        yield Pair(vehicle=its_vehicle, companion=its_companion, px4=its_px4)


@contextlib.contextmanager
def running(program: Program, *, ends_s: float) -> Iterator[Process]:
    """Start a process; on any way out, give it so long to end by itself, then kill its group."""
    with subprocess.Popen(  # noqa: S603  our own programs
        program.command,
        env=environment() if program.environment is None else program.environment,
        cwd=program.folder,
        stdin=subprocess.DEVNULL,
        stdout=program.stdout,
        stderr=program.stderr,
        start_new_session=True,  # a Ctrl-C reaches the starter alone, which passes it on
        preexec_fn=functools.partial(  # noqa: PLW1509  it takes no lock that a thread could hold
            _die_with_parent, program.orphan_signal
        ),
    ) as process:
        try:
            yield process
        finally:
            if ends_s > 0.0 and process.poll() is None:
                process.terminate()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    process.wait(ends_s)
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def environment() -> dict[str, str]:
    """Return this process's own; what can be imported here can be there, a user's policy too."""
    path = os.pathsep.join(filter(None, sys.path))
    return {"OMP_NUM_THREADS": "1"} | os.environ | {"PYTHONPATH": path}


def _die_with_parent(number: int) -> None:
    """Ask Linux to end this child by a signal when the starter is killed outright."""
    LIBC.prctl(PR_SET_PDEATHSIG, number)
