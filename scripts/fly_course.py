"""Fly one course: start the vehicle and the companion as two processes, wait, clean up.

The vehicle runs in lockstep, so the same seeds give the same flight at any speed. The two meet on
the offboard API port of the first free instance: several flights may run side by side.
"""

import argparse
import contextlib
import ctypes
import fcntl
import json
import os
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import IO

INSTANCES = 10  # PX4 gives every instance its own offboard API port up to 14549
API_PORT = 14540  # the companion's end, + instance
PORTS_UDP = (18570, 14580, API_PORT)  # vehicle's GCS and API links, companion; + instance
CAMERA_PORT = 8090  # + instance
LAP_LIMIT_S = 90.0  # vehicle time: whoever needs longer has lost the course
COMPANION_NOTICES_S = 8.0  # a companion whose vehicle died ends by itself within 5 s
VEHICLE_ENDS_S = 5.0  # after SIGTERM: flush the log and leave
VEHICLE_REFUSED = (2, 3)  # exit codes of a vehicle that never started: usage, ports
NO_LINK = 3  # exit code
PR_SET_PDEATHSIG = 1  # Linux prctl


def parse_arguments(argv: list[str]) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(
        prog="scripts/fly", description="Fly one course in simulation and say what happened."
    )
    parser.add_argument("--laps", type=int, default=1, help="laps of 8 gates (default 1)")
    parser.add_argument("--track-seed", type=int, default=0, help="which track (default 0)")
    parser.add_argument(
        "--noise",
        default="1.0,2.0",
        metavar="GRN,GHN",
        help="noise of the gates' radius and height in m (default 1.0,2.0)",
    )
    parser.add_argument("--model", help="which model flies (default: the companion's)")
    parser.add_argument("--strategy", help="how it decides (default: the model's)")
    speed = parser.add_mutually_exclusive_group()
    speed.add_argument(
        "--speed-factor", type=float, default=1.0, help="times real time (default 1)"
    )
    speed.add_argument("--fast", action="store_true", help="as fast as possible")
    parser.add_argument(
        "--json", action="store_true", help="last line of output: the result as one JSON object"
    )
    return parser.parse_args(argv)


def vehicle_command(options: argparse.Namespace, instance: int) -> list[str]:
    """Spell out the vehicle's process."""
    return [
        *(sys.executable, "-m", "sitl", "--lockstep", "-q", f"--instance={instance}"),
        *(f"--laps={options.laps}", f"--track-seed={options.track_seed}"),
        *(
            f"--noise={options.noise}",
            f"--speed-factor={0 if options.fast else options.speed_factor}",
        ),
    ]


def companion_command(options: argparse.Namespace, instance: int) -> list[str]:
    """Spell out the companion's process."""
    names = [name for name in ("model", "strategy") if getattr(options, name) is not None]
    return [
        *(sys.executable, "-m", "flightstack.companion", f"--udp={API_PORT + instance}"),
        f"--duration={LAP_LIMIT_S * options.laps}",
        *(f"--{name}={getattr(options, name)}" for name in names),
        *(["--json"] if options.json else []),
    ]


@contextlib.contextmanager
def free_instance() -> Iterator[int]:
    """Hold the first instance whose ports are free, against other flights of this user too."""
    for instance in range(INSTANCES):
        name = f"flightstack-{os.getuid()}-{instance}.lock"
        with Path(tempfile.gettempdir(), name).open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            if _ports_free(instance):
                yield instance
                return
    last = API_PORT + INSTANCES - 1
    print(
        f"scripts/fly: UDP ports {API_PORT} to {last} are all taken: end another flight first",
        file=sys.stderr,
    )
    sys.exit(NO_LINK)


def _ports_free(instance: int) -> bool:
    udp = [(socket.SOCK_DGRAM, port + instance) for port in PORTS_UDP]
    for kind, port in [*udp, (socket.SOCK_STREAM, CAMERA_PORT + instance)]:
        with socket.socket(socket.AF_INET, kind) as probe:
            if kind == socket.SOCK_STREAM:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                return False
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """The two processes, each the leader of its own group."""

    vehicle: subprocess.Popen[str]
    companion: subprocess.Popen[str]

    def pass_on(self, signum: int, _frame: FrameType | None) -> None:
        """Hand a signal to the companion: it lands first, and at the second signal leaves."""
        if self.companion.poll() is None:
            self.companion.send_signal(signum)

    def end(self) -> None:
        """Leave nothing behind: ask the vehicle to flush its log, then kill what remains."""
        if self.vehicle.poll() is None:
            self.vehicle.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.vehicle.wait(VEHICLE_ENDS_S)
        for process in (self.vehicle, self.companion):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def _die_with_parent() -> None:
    """Ask Linux to end this child when the launcher is killed outright."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)


@contextlib.contextmanager
def started(
    options: argparse.Namespace, instance: int, companion_stdout: IO[str] | None
) -> Iterator[Flight]:
    """Start both processes; on any way out, end them."""
    root = Path(__file__).resolve().parent.parent
    path = os.pathsep.join(filter(None, [str(root), os.environ.get("PYTHONPATH")]))
    environment = {"OMP_NUM_THREADS": "1"} | os.environ | {"PYTHONPATH": path}

    def start(command: list[str], stdout: IO[str] | None = None) -> subprocess.Popen[str]:
        return subprocess.Popen(
            command,
            env=environment,
            text=True,
            stdin=subprocess.DEVNULL,
            stdout=stdout,
            start_new_session=True,  # a Ctrl-C reaches the launcher alone, which passes it on
            preexec_fn=_die_with_parent,  # noqa: PLW1509 - the launcher has no threads
        )

    vehicle = start(vehicle_command(options, instance))
    flight = Flight(
        vehicle=vehicle, companion=start(companion_command(options, instance), companion_stdout)
    )
    try:
        for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(signum, flight.pass_on)
        yield flight
    finally:
        flight.end()


def wait_for_end(flight: Flight) -> int:
    """Wait for the companion: its exit code, or that of a vehicle that refused to start."""
    with contextlib.ExitStack() as stack, selectors.DefaultSelector() as selector:
        for process in (flight.vehicle, flight.companion):
            pidfd = os.pidfd_open(process.pid)
            stack.callback(os.close, pidfd)
            selector.register(pidfd, selectors.EVENT_READ)
        patience_s = None  # endless, as long as both live
        while flight.companion.poll() is None:
            events = selector.select(patience_s)
            if flight.vehicle.poll() in VEHICLE_REFUSED:
                return int(flight.vehicle.returncode)
            if not events:
                flight.companion.terminate()
            for key, _ in events:
                selector.unregister(key.fileobj)
                patience_s = COMPANION_NOTICES_S
        return flight.companion.returncode


def result_line(companion_output: str, options: argparse.Namespace, exit_code: int) -> str:
    """Complete the companion's result, one JSON object, by what only the launcher knows."""
    last_line = companion_output.rstrip().rpartition("\n")[2]
    result = json.loads(last_line) if last_line.startswith("{") else {"outcome": "did not fly"}
    noise = [float(figure) for figure in options.noise.split(",")] if exit_code != 2 else None
    return json.dumps({**result, "track_seed": options.track_seed, "noise": noise})


def main(argv: list[str] | None = None) -> int:
    """Fly; the companion's exit code is the command's."""
    options = parse_arguments(sys.argv[1:] if argv is None else argv)
    with free_instance() as instance:
        if not options.json:
            with started(options, instance, None) as flight:
                return wait_for_end(flight)
        with tempfile.TemporaryFile("w+") as output:
            with started(options, instance, output) as flight:
                exit_code = wait_for_end(flight)
            output.seek(0)
            print(result_line(output.read(), options, exit_code))
            return exit_code


if __name__ == "__main__":
    sys.exit(main())
