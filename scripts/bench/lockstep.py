"""Measure how fast lockstep flies, and where the time goes.

    python scripts/bench/lockstep.py [--laps 4] [--track-seed 0] [--noise 0,0] [--model NAME]
                                     [--against COMMIT [--rounds 4]]

Flies vehicle and companion as two processes over their sockets, as fast as they can: once as they
are, for the real-time factor from the first image to the disarming; and once with their parts
timed, for the CPU time of every part in the stretch in which the network flew. With a commit it
flies that commit's code in turns with this one, now the one first, now the other, and prints the
least cost of each side by side, with their ratio, and the median of the ratios of all turns, which
other load disturbs alike. Wall times say something on an idle machine only.
"""

import argparse
import os
import statistics
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from flightstack.launch import fly  # noqa: E402
from scripts.bench.flying import (  # noqa: E402
    ROLES,
    Report,
    Stretch,
    add_comparison_options,
    add_flight_options,
    fly_together,
    in_turns,
)

TICK_PARTS = ("autopilot", "physics", "referee, estimate")  # of the vehicle
TICKS_PER_IMAGE = 12.5
MIN_DECISIONS = 20  # a second of flight


def fly_untimed(options: argparse.Namespace) -> float:
    """Fly once as `scripts/fly` does; the real-time factor of the whole mission."""
    radius_m, height_m = map(float, options.noise.split(","))
    flown = fly(
        laps=options.laps,
        track_seed=options.track_seed,
        noise=(radius_m, height_m),
        model=options.model,
        fast=True,
    )
    return flown.real_time_factor


def fly_timed(options: argparse.Namespace, root: Path = ROOT) -> tuple[dict[str, Stretch], int]:
    """Fly once with all parts timed; both processes while the network flew, and its images."""
    report = _fly(options, root)
    images, _ = report.images(*report.flown)
    return {role: report.stretch(role, *report.flown) for role in ROLES}, images


def _fly(options: argparse.Namespace, root: Path, *, parts: bool = True) -> Report:
    report = fly_together(options, 1, parts=parts, root=root)[0]
    if len(report.decided) < MIN_DECISIONS:
        sys.exit("lockstep.py: the network flew for less than a second: no figures")
    return report


def print_parts(console: Console, title: str, stretch: Stretch, images: int) -> None:
    """Print one process: CPU time by part, per image and in percent."""
    table = Table(title=title, title_justify="left")
    table.add_column("part")
    for heading in ("ms per image", "% of its CPU", "calls per image"):
        table.add_column(heading, justify="right")
    rest_s = stretch.process_cpu_s - sum(stretch.cpu_s.values())
    parts = sorted(stretch.cpu_s.items(), key=lambda item: -item[1])
    for part, cpu_s in [*parts, ("(not in any part)", rest_s)]:
        calls = stretch.calls.get(part)
        table.add_row(
            part,
            f"{cpu_s / images * 1e3:.2f}",
            f"{cpu_s / stretch.process_cpu_s:.1%}",
            "" if calls is None else f"{calls / images:.1f}",
        )
    waiting_s = max(0.0, stretch.wall_s - stretch.process_cpu_s)
    table.add_row("(waiting)", f"{waiting_s / images * 1e3:.2f}", "", "", style="dim")
    console.print(table)


def tick_figures(options: argparse.Namespace, root: Path) -> dict[str, float]:
    """Fly with all parts timed; CPU us per tick by part."""
    stretches, images = fly_timed(options, root)
    ticks, vehicle = images * TICKS_PER_IMAGE, stretches["vehicle"].cpu_s
    parts = {f"{part}, us per tick": vehicle[part] / ticks * 1e6 for part in TICK_PARTS}
    return {**parts, "whole tick, us": sum(parts.values())}


def image_figures(options: argparse.Namespace, root: Path) -> dict[str, float]:
    """Fly with nothing but the processes timed; CPU ms per image by process, and the speed."""
    report = _fly(options, root, parts=False)
    start_s, end_s = report.flown
    images, vehicle_s = report.images(start_s, end_s)
    costs = {
        f"{role}, ms per image": report.stretch(role, start_s, end_s).process_cpu_s / images * 1e3
        for role in ROLES
    }
    both = sum(costs.values())
    return {
        **costs,
        "both, ms per image": both,
        "wall time, ms per simulated s": (end_s - start_s) / vehicle_s * 1e3,
        "wall time, ms of the median image": statistics.median(report.image_times_s) * 1e3,
    }


def compare(console: Console, options: argparse.Namespace, commit: str) -> None:
    """Fly this code and a commit's in turns; print what each cost at its least, and the ratios."""
    flown = in_turns(
        commit,
        options.rounds,
        lambda root: tick_figures(options, root) | image_figures(options, root),
    )
    title = f"The least of {options.rounds} flights each; CPU time unless it says wall"
    table = Table(title=title, title_justify="left")
    table.add_column("")
    for name in (*flown, "ratio", "by turn"):
        table.add_column(name, justify="right")
    for figure in flown[commit][0]:
        there, here = ([flight[figure] for flight in flights] for flights in flown.values())
        min_there, min_here = min(there), min(here)
        by_turn = statistics.median(b / a for a, b in zip(there, here, strict=True))
        table.add_row(
            figure,
            *(f"{min_there:.2f}", f"{min_here:.2f}"),
            *(f"{min_here / min_there:.2f}", f"{by_turn:.2f}"),
        )
    console.print(table)


def main() -> int:
    """Fly, and print the tables."""
    parser = argparse.ArgumentParser(prog="lockstep.py", description=(__doc__ or "").split("\n")[0])
    add_flight_options(parser)
    add_comparison_options(parser)
    options = parser.parse_args()
    console = Console(width=78)
    console.print(f"load of this machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    if options.against:
        compare(console, options, options.against)
        return 0
    console.print(f"as it is: [bold]{fly_untimed(options):.1f} times real time[/bold]")
    stretches, images = fly_timed(options)
    for role, stretch in stretches.items():
        print_parts(console, role, stretch, images)
    return 0


if __name__ == "__main__":
    sys.exit(main())
