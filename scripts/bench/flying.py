"""Fly vehicle and companion as two processes with their parts timed, for the benches beside."""

import argparse
import contextlib
import itertools
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightstack.launch.instances import free_instance
from flightstack.launch.ports import Ports
from flightstack.launch.processes import Process, Program, started
from flightstack.launch.request import FlightRequest

ROOT = Path(__file__).resolve().parents[2]
PROFILED = Path("scripts", "bench", "profiled.py")  # each commit's own: it knows its modules
ROLES = ("vehicle", "companion")
LIMIT_S = 600.0
Figures = dict[str, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """One process between two moments."""

    wall_s: float
    process_cpu_s: float
    cpu_s: dict[str, float]
    calls: dict[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What both processes of one flight have written down."""

    snapshots: dict[str, list[dict[str, Any]]]  # by role
    decided: list[tuple[float, int]]  # wall time s, image stamp us

    @property
    def flown(self) -> tuple[float, float]:
        """Wall times of the first and the last decision."""
        return self.decided[0][0], self.decided[-1][0]

    @property
    def image_times_s(self) -> list[float]:
        """Wall time from each decision to the next."""
        return [after - before for (before, _), (after, _) in itertools.pairwise(self.decided)]

    def stretch(self, role: str, start_s: float, end_s: float) -> Stretch:
        """Subtract the snapshots at both ends."""
        inside = [s for s in self.snapshots[role] if start_s <= s["wall_s"] <= end_s]
        first, last = inside[0], inside[-1]

        def spent(kind: str) -> dict[str, Any]:
            return {part: last[kind][part] - first[kind].get(part, 0) for part in last[kind]}

        return Stretch(
            wall_s=last["wall_s"] - first["wall_s"],
            process_cpu_s=last["process_cpu_s"] - first["process_cpu_s"],
            cpu_s=spent("cpu_s"),
            calls=spent("calls"),
        )

    def images(self, start_s: float, end_s: float) -> tuple[int, float]:
        """How many images were decided on in a stretch, and their vehicle time in s."""
        stamps_us = [stamp_us for wall_s, stamp_us in self.decided if start_s <= wall_s <= end_s]
        return len(stamps_us) - 1, (stamps_us[-1] - stamps_us[0]) / 1e6


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Which course is flown, and by what."""
    parser.add_argument("--laps", type=int, default=4)
    parser.add_argument("--track-seed", type=int, default=0)
    parser.add_argument("--noise", default="0,0", metavar="GRN,GHN")
    parser.add_argument("--model")


def add_comparison_options(parser: argparse.ArgumentParser) -> None:
    """Which other code is flown in turns with this one."""
    parser.add_argument("--against", metavar="COMMIT", help="print another commit's cost beside")
    parser.add_argument(
        "--rounds", type=int, choices=range(1, 100), default=4, help="flights of each code"
    )


def in_turns(
    commit: str, rounds: int, measure: Callable[[Path], Figures]
) -> dict[str, list[Figures]]:
    """Measure a commit's code and this one in turns, now the one first, now the other."""
    measured: dict[str, list[Figures]] = {commit: [], "here": []}
    with checked_out(commit) as other:
        turns = [(commit, other), ("here", ROOT)]
        for _ in range(rounds):
            for name, root in turns:
                measured[name].append(measure(root))
            turns.reverse()
    return measured


@contextlib.contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """Have a commit's files in a folder for a while."""
    git = ("git", "-C", str(ROOT), "worktree")
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder, "code")
        subprocess.run([*git, "add", "--quiet", "--detach", str(root), commit], check=True)
        try:
            yield root
        finally:
            subprocess.run([*git, "remove", "--force", str(root)], check=True)


@contextlib.contextmanager
def flying(
    options: argparse.Namespace, folder: Path, *, parts: bool = True, root: Path = ROOT
) -> Iterator[Process]:
    """Fly with the code at `root`; gives the companion's process."""
    environment = os.environ | {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1"}
    detail = "parts" if parts else "whole"

    def program(role: str, arguments: list[str]) -> Program:
        report = str(folder / f"{role}.json")
        return Program(
            command=[sys.executable, str(root / PROFILED), role, detail, report, *arguments],
            stdout=subprocess.DEVNULL,  # its summary names a log that goes with the folder
            environment=environment,
            folder=root,
        )

    request = FlightRequest(
        laps=options.laps,
        track_seed=options.track_seed,
        noise=options.noise,
        model=options.model,
        speed_factor=0.0,
        vehicle_options=("-q",),
        companion_options=("-q", f"--log={folder / 'flight.tlog'}"),
    )
    with free_instance() as instance:
        ports = Ports.of_instance(instance)
        vehicle = program("vehicle", request.vehicle_arguments(ports))
        companion = program("companion", request.companion_arguments(ports))
        with started(vehicle, companion) as pair:
            yield pair.companion


def fly_together(
    options: argparse.Namespace, count: int, *, parts: bool = True, root: Path = ROOT
) -> list[Report]:
    """Fly the same course `count` times at once."""
    with contextlib.ExitStack() as stack:
        folders = [Path(stack.enter_context(tempfile.TemporaryDirectory())) for _ in range(count)]
        with contextlib.ExitStack() as flights:
            companions = [
                flights.enter_context(flying(options, folder, parts=parts, root=root))
                for folder in folders
            ]
            for companion in companions:
                companion.wait(LIMIT_S)
        return [_read(folder) for folder in folders]


def _read(folder: Path) -> Report:
    reports = {role: json.loads((folder / f"{role}.json").read_text()) for role in ROLES}
    return Report(
        snapshots={role: report["snapshots"] for role, report in reports.items()},
        decided=[(wall_s, stamp_us) for wall_s, stamp_us in reports["companion"]["decided"]],
    )
