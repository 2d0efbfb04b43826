"""Fly once, with one fault that begins in one phase, and say what came of it."""

import contextlib
import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from subprocess import STDOUT
from typing import Any

from flightstack.launch.instances import free_instance
from flightstack.launch.ports import Ports
from flightstack.launch.processes import Process, Program, module, running
from flightstack.logs import read
from flightstack.logs.errors import LogFileError
from scripts.bench.faults.parts import TRIGGER
from scripts.bench.faults.relays import CameraRelay, LinkRelay

CAMERA_PORT = 8090  # + instance
STATION_PORT = 18570  # + instance, the vehicle's link for ground stations
PHASES = ("before arming", "take-off", "flying", "landing")
STARTS_S, LIMIT_S, GROUND_S = 60.0, 150.0, 60.0  # wall time
COURSE = ("--noise=0,0", "--laps=1")
PARTS = Path(__file__).parent


@dataclass(slots=True)
class Flown:
    """What is known of one flight."""

    code: int | None = None  # of the companion; None where it had to be ended
    outcome: str = "none"
    gates: int = 0
    said: str = ""  # the first warning, or else the result line
    died_badly: bool = False  # by an exception that nobody caught
    armed: bool = False  # in the end
    vehicle_ran: bool = True
    log_whole: bool = False
    wall_s: float = 0.0


@dataclass(slots=True)
class Scene:
    """What a fault can get at."""

    folder: Path
    instance: int
    link: LinkRelay
    camera: CameraRelay
    start: Callable[..., Process]
    vehicle: Process
    companion: Process
    trigger: Path
    others: list[Process] = field(default_factory=list)


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One kind of fault, and what has to be so for it."""

    name: str
    begin: Callable[[Scene], None]
    companion: tuple[str, ...] = ()  # options
    vehicle_survives: bool = True
    companion_survives: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightKind:
    """What is flown: the phase in which the fault begins, in lockstep or in real time."""

    phase: str
    lockstep: bool = True
    duration_s: float = 12.0  # in OFFBOARD, at most
    after_s: float = 0.0  # wall time, from the beginning of the phase


def fly(fault: Fault, flight: FlightKind, folder: Path, seed: int = 0) -> Flown:
    """Fly a course with the fault from this flight's phase on."""
    began_s = time.monotonic()
    with _scene(fault, flight, folder, seed) as scene:
        _wait(lambda: scene.link.phase == flight.phase or _ended(scene.companion), STARTS_S)
        time.sleep(flight.after_s)
        fault.begin(scene)
        _wait(lambda: _ended(scene.companion), LIMIT_S)
        code = scene.companion.poll()
        _wait(lambda: _is_down(scene), GROUND_S)
        flown = _read(scene, code)
    flown.wall_s = time.monotonic() - began_s
    logs = (folder / "again.tlog", folder / "companion.tlog")
    flown.log_whole = _is_whole(next((log for log in logs if log.exists()), logs[-1]))
    return flown


@contextlib.contextmanager
def _scene(fault: Fault, flight: FlightKind, folder: Path, seed: int) -> Iterator[Scene]:
    trigger = folder / "trigger"
    with contextlib.ExitStack() as stack:
        instance = stack.enter_context(free_instance())
        port = Ports.find().companion
        link = stack.enter_context(LinkRelay(port, seed))
        camera = stack.enter_context(CameraRelay(CAMERA_PORT + instance))

        def start(name: str, *options: str, output: str) -> Process:
            said = stack.enter_context((folder / output).open("ab"))
            program: Program = module(name, options, said, STDOUT)
            paths = f"{PARTS}:{Path(__file__).parents[3]}"
            extra = {"PYTHONPATH": paths, TRIGGER: str(trigger), "OMP_NUM_THREADS": "1"}
            program = replace(program, environment=os.environ | extra)
            return stack.enter_context(running(program, ends_s=5.0))

        pace = ("--lockstep", "--speed-factor=0") if flight.lockstep else ()
        vehicle_options = (*pace, *COURSE, f"--instance={instance}", f"--api-link=0:{link.port}")
        companion_options = (
            *(f"--udp={port}", f"--camera={camera.uri}", f"--log={folder / 'companion.tlog'}"),
            *(
                "--json",
                "--reach=30",
                "--timeout=15",
                f"--duration={flight.duration_s:g}",
                *fault.companion,
            ),
        )
        yield Scene(
            folder=folder,
            instance=instance,
            link=link,
            camera=camera,
            start=start,
            vehicle=start("sitl", *vehicle_options, output="vehicle.txt"),
            companion=start("flightstack.companion", *companion_options, output="companion.txt"),
            trigger=trigger,
        )


def start_again(scene: Scene, *options: str) -> None:
    """Start the companion anew, as whoever watches over it does."""
    command = list(map(str, scene.companion.args))[3:]  # type: ignore[arg-type]
    log = f"--log={scene.folder / 'again.tlog'}"
    scene.companion = scene.start(
        "flightstack.companion", *command, log, *options, output="companion.txt"
    )


def end(process: Process) -> None:
    """Kill one, outright."""
    process.send_signal(signal.SIGKILL)
    process.wait()


def pause(process: Process, for_s: float) -> None:
    """Stop one for a while."""
    process.send_signal(signal.SIGSTOP)
    time.sleep(for_s)
    process.send_signal(signal.SIGCONT)


def worker_of(companion: Process) -> int | None:
    """Return the process in which the companion's parts work."""
    children = Path(f"/proc/{companion.pid}/task/{companion.pid}/children").read_text().split()
    return int(children[0]) if children else None


def _ended(process: Process) -> bool:
    return process.poll() is not None


def _is_down(scene: Scene) -> bool:
    """Whether the vehicle has disarmed, or is no more."""
    return _ended(scene.vehicle) or not scene.link.armed


def _wait(condition: Callable[[], bool], limit_s: float) -> None:
    ends_s = time.monotonic() + limit_s
    while not condition() and time.monotonic() < ends_s:
        time.sleep(0.005)


def _read(scene: Scene, code: int | None) -> Flown:
    said = (scene.folder / "companion.txt").read_text(errors="replace")
    lines = said.splitlines()
    results: list[dict[str, Any]] = [json.loads(line) for line in lines if line[:1] == "{"]
    result = results[-1] if results else {}
    marks = ("warning: ", "flightstack.companion: ", "trying to reach")
    words = [line for line in lines if line.startswith(marks)]
    return Flown(
        code=code,
        outcome=result.get("outcome", "none"),
        gates=result.get("gates_passed", 0),
        said=words[0].removeprefix("warning: ") if words else "",
        died_badly="Traceback" in said,
        armed=scene.link.armed and not _ended(scene.vehicle),
        vehicle_ran=not _ended(scene.vehicle),
    )


def _is_whole(log: Path) -> bool:
    """Whether the log can be read to its end: all complete records come back."""
    try:
        return "HEARTBEAT" in read(log)
    except (OSError, LogFileError):  # not there, or empty: the flight had not begun
        return False
