"""Measure how fast lockstep flies, and where the time goes.

    python scripts/bench/lockstep.py [--laps 4] [--track-seed 0] [--noise 0,0] [--model NAME]

Flies vehicle and companion as two processes over their sockets, as fast as they can: once as they
are, for the real-time factor from the first frame to the disarming; and once with their parts
timed, for the CPU time of every part in the stretch in which the network flew.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[2]
PROFILED = Path(__file__).with_name("profiled.py")
sys.path.insert(0, str(ROOT))

from scripts.fly_course import API_PORT, LAP_LIMIT_S, free_instance  # noqa: E402

FLY = (sys.executable, str(ROOT / "scripts" / "fly_course.py"), "--fast", "--json")
LIMIT_S = 600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Stretch:
    """One process between two moments."""

    wall_s: float
    process_cpu_s: float
    cpu_s: dict[str, float]
    calls: dict[str, int]


def between(report: dict[str, Any], start_s: float, end_s: float) -> Stretch:
    """Subtract the snapshots at both ends."""
    inside = [s for s in report["snapshots"] if start_s <= s["wall_s"] <= end_s]
    first, last = inside[0], inside[-1]

    def spent(kind: str) -> dict[str, Any]:
        return {part: last[kind][part] - first[kind].get(part, 0) for part in last[kind]}

    return Stretch(
        wall_s=last["wall_s"] - first["wall_s"],
        process_cpu_s=last["process_cpu_s"] - first["process_cpu_s"],
        cpu_s=spent("cpu_s"),
        calls=spent("calls"),
    )


def fly(options: argparse.Namespace, folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Fly once; the reports of vehicle and companion."""
    reports = {role: folder / f"{role}.json" for role in ("vehicle", "companion")}
    environment = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}

    def command(role: str, *arguments: str) -> list[str]:
        return [sys.executable, str(PROFILED), role, str(reports[role]), *arguments]

    with free_instance() as instance:
        course = (f"--laps={options.laps}", f"--track-seed={options.track_seed}")
        flight = ("--lockstep", "--speed-factor=0", "-q", f"--instance={instance}")
        pilot = (f"--udp={API_PORT + instance}", f"--duration={LAP_LIMIT_S * options.laps}", "-q")
        model = (f"--model={options.model}",) if options.model else ()
        vehicle = subprocess.Popen(
            command("vehicle", *flight, *course, f"--noise={options.noise}"), env=environment
        )
        try:
            subprocess.run(
                command("companion", *pilot, *model, f"--log={folder / 'flight.tlog'}"),
                env=environment,
                stdout=subprocess.DEVNULL,  # its summary names a log that goes with the folder
                timeout=LIMIT_S,
                check=False,
            )
        finally:
            vehicle.terminate()
            vehicle.wait()
    vehicle_report, companion_report = (json.loads(path.read_text()) for path in reports.values())
    return vehicle_report, companion_report


def fly_untimed(options: argparse.Namespace) -> float:
    """Fly once by `scripts/fly`; the real-time factor of the whole mission."""
    course = (f"--laps={options.laps}", f"--track-seed={options.track_seed}")
    model = (f"--model={options.model}",) if options.model else ()
    flight = subprocess.run(
        [*FLY, *course, *model, f"--noise={options.noise}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    return float(json.loads(flight.stdout.splitlines()[-1])["real_time_factor"])


def print_table(console: Console, title: str, stretch: Stretch, frames: int) -> None:
    """Print one process: CPU time by part, a frame and in percent."""
    table = Table(title=title, title_justify="left")
    table.add_column("part")
    for heading in ("ms a frame", "% of its CPU", "calls a frame"):
        table.add_column(heading, justify="right")
    rest_s = stretch.process_cpu_s - sum(stretch.cpu_s.values())
    parts = sorted(stretch.cpu_s.items(), key=lambda item: -item[1])
    for part, cpu_s in [*parts, ("(not in any part)", rest_s)]:
        calls = stretch.calls.get(part)
        table.add_row(
            part,
            f"{cpu_s / frames * 1e3:.2f}",
            f"{cpu_s / stretch.process_cpu_s:.1%}",
            "" if calls is None else f"{calls / frames:.1f}",
        )
    waiting_s = max(0.0, stretch.wall_s - stretch.process_cpu_s)
    table.add_row("(waiting)", f"{waiting_s / frames * 1e3:.2f}", "", "", style="dim")
    console.print(table)


def main() -> int:
    """Fly, and print the tables."""
    parser = argparse.ArgumentParser(prog="lockstep.py", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--laps", type=int, default=4)
    parser.add_argument("--track-seed", type=int, default=0)
    parser.add_argument("--noise", default="0,0", metavar="GRN,GHN")
    parser.add_argument("--model")
    options = parser.parse_args()
    console = Console(width=78)
    console.print(f"as it is: [bold]{fly_untimed(options):.1f} times real time[/bold]")
    with tempfile.TemporaryDirectory() as folder:
        vehicle, companion = fly(options, Path(folder))
    decided = companion["decided"]
    if len(decided) < 20:
        print("lockstep.py: the network flew for less than a second: no figures", file=sys.stderr)
        return 1
    (start_s, start_us), (end_s, end_us) = decided[0], decided[-1]
    frames = len(decided) - 1
    vehicle_s, wall_s = (end_us - start_us) / 1e6, end_s - start_s
    console.print(
        f"timed: {frames} frames, {vehicle_s:.1f} s of flight in {wall_s:.2f} s, "
        f"{vehicle_s / wall_s:.1f} times real time"
    )
    print_table(console, "vehicle", between(vehicle, start_s, end_s), frames)
    print_table(console, "companion", between(companion, start_s, end_s), frames)
    return 0


if __name__ == "__main__":
    sys.exit(main())
