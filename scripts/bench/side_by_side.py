"""Measure what flights cost that are flown side by side: simulated seconds per wall second in all.

    python scripts/bench/side_by_side.py [--flights 2] [--laps 4] [--track-seed 0] [--noise 0,0]
                                         [--against COMMIT [--rounds 4]]

Each flight is a vehicle and a companion in lockstep, as fast as they can. Counted is the stretch in
which the networks of all of them flew, by CPU time, which other load disturbs least. With a commit
it flies that commit's code in turns with this one, and prints the greatest speed of each, and the
median of the ratios of all turns.
"""

import argparse
import os
import statistics
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from scripts.bench.flying import (
    ROLES,
    Figures,
    Report,
    add_comparison_options,
    add_flight_options,
    fly_together,
    in_turns,
)

SPEED = "simulated seconds per wall second"


def print_flights(console: Console, reports: list[Report], start_s: float, end_s: float) -> None:
    """Print each flight, and all of them."""
    table = Table(title="CPU time, ms per image", title_justify="left")
    for heading in ("flight", *ROLES, "both", "times real time"):
        table.add_column(heading, justify="right")
    for number, report in enumerate(reports):
        images, vehicle_s = report.images(start_s, end_s)
        costs = [
            report.stretch(role, start_s, end_s).process_cpu_s / images * 1e3 for role in ROLES
        ]
        speed = vehicle_s / (end_s - start_s)
        table.add_row(
            str(number), *(f"{cost:.2f}" for cost in (*costs, sum(costs))), f"{speed:.1f}"
        )
    console.print(table)
    console.print(f"in all: [bold]{speed_in_all(reports, start_s, end_s):.1f} {SPEED}[/bold]")


def print_speeds(console: Console, speeds: dict[str, list[float]]) -> None:
    """Print the greatest speed of each of two codes, and how many times faster the second is."""
    for name, found in speeds.items():
        console.print(f"{name}: {max(found):.1f} {SPEED} at best")
    there, here = speeds.values()
    ratio = statistics.median(b / a for a, b in zip(there, here, strict=True))
    console.print(f"by turn: [bold]{ratio:.2f}[/bold] times as fast")


def speed_in_all(reports: list[Report], start_s: float, end_s: float) -> float:
    """Add up what all flights flew between two wall times; simulated seconds per wall second."""
    return sum(report.images(start_s, end_s)[1] for report in reports) / (end_s - start_s)


def common_stretch(reports: list[Report]) -> tuple[float, float]:
    """Give the wall times between which the networks of all flights flew; exits without any."""
    flown = [report.flown for report in reports]
    start_s, end_s = max(start for start, _ in flown), min(end for _, end in flown)
    if end_s - start_s < 1.0:
        sys.exit("side_by_side.py: the flights hardly met: no figures")
    return start_s, end_s


def measure_speed(options: argparse.Namespace, root: Path) -> Figures:
    """Fly with the code at `root`."""
    reports = fly_together(options, options.flights, parts=False, root=root)
    return {SPEED: speed_in_all(reports, *common_stretch(reports))}


def main() -> int:
    """Fly, and print the table."""
    parser = argparse.ArgumentParser(
        prog="side_by_side.py", description=(__doc__ or "").split("\n")[0]
    )
    add_flight_options(parser)
    add_comparison_options(parser)
    parser.add_argument("--flights", type=int, default=2, help="how many at once (default 2)")
    options = parser.parse_args()
    console = Console(width=78)
    console.print(f"load of this machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    if options.against:
        speeds = in_turns(
            options.against, options.rounds, lambda root: measure_speed(options, root)
        )
        print_speeds(
            console, {name: [each[SPEED] for each in found] for name, found in speeds.items()}
        )
        return 0
    reports = fly_together(options, options.flights, parts=False)
    print_flights(console, reports, *common_stretch(reports))
    return 0


if __name__ == "__main__":
    sys.exit(main())
