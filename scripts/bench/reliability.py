"""Fly with something broken in each flight, and write down what came of it.

    python scripts/bench/reliability.py faults|links|kills [--only NAME ...] [--phase NAME ...]
                                        [--real-time] [--count 100] [--jobs 1] [--write]

faults  each kind of fault, from each phase on: parts, camera, vehicle, companion
links   loss, delay, duplicates, changed order and outages, from each phase on
kills   SIGKILL, and SIGSTOP with SIGCONT, of either side at random moments

In lockstep, as fast as it goes; or in real time. `--write` puts the table into
docs/reliability.md. The exit code is 1 where a flight ended by an exception, where a vehicle that
runs stayed armed, where a companion that lives gave no result, or where a log cannot be read.
Hostile input and the long flight have scripts of their own: hostile_companion.py, soak.py.
"""

import argparse
import fnmatch
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from scripts.bench.faults.flights import PHASES, Fault, FlightKind, Flown, fly  # noqa: E402
from scripts.bench.faults.kinds import FAULTS, KILLS, LINKS, STOPS  # noqa: E402

DOCUMENT = ROOT / "docs" / "reliability.md"
LATEST_S = 2.0  # after the beginning of a phase
ITS_OWN = ("take-off",)  # without a companion PX4 goes on and holds: NAV_DLL_ACT is 0 by default
SAID_CHARACTERS = 70


class Order(NamedTuple):
    """One flight to be flown."""

    fault: Fault
    phase: str
    seed: int
    after_s: float = 0.0  # wall time, from the beginning of the phase


class Row(NamedTuple):
    """One flight that was flown."""

    order: Order
    flown: Flown

    def wrong(self) -> list[str]:
        """Say what is not as it must be; nothing if all is."""
        (fault, phase, *_), flown = self.order, self.flown
        killed = not fault.companion_survives
        never_began = phase == "before arming" and flown.outcome == "none"
        findings = {
            "ended by an exception": flown.died_badly,
            "the vehicle is still armed": flown.armed and not (killed and phase in ITS_OWN),
            "no result line": not killed and not never_began and flown.outcome == "none",
            "the log cannot be read": not never_began and not flown.log_whole,
        }
        return [words for words, found in findings.items() if found]


def orders(options: argparse.Namespace) -> list[Order]:
    """Say what is to be flown."""
    if options.what == "kills":
        rng = random.Random(options.seed)  # noqa: S311
        kinds: tuple[Fault, ...] = (*KILLS, *STOPS)
        chosen = [kinds[number % len(kinds)] for number in range(options.count)]
        return [
            Order(fault, rng.choice(PHASES), number, rng.uniform(0.0, LATEST_S))
            for number, fault in enumerate(chosen)
        ]
    kinds = FAULTS if options.what == "faults" else LINKS
    names = options.only or ["*"]
    return [
        Order(fault, phase, 0)
        for fault in kinds
        if any(fnmatch.fnmatch(fault.name, name) for name in names)
        for phase in options.phase or PHASES
    ]


def flown(order: Order, options: argparse.Namespace) -> Row:
    """Fly one."""
    with tempfile.TemporaryDirectory() as folder:
        kind = FlightKind(
            phase=order.phase,
            lockstep=not options.real_time,
            duration_s=options.duration,
            after_s=order.after_s,
        )
        result = fly(order.fault, kind, Path(folder), order.seed)
    row = Row(order, result)
    state = "; ".join(row.wrong()) or "good"
    print(
        f"{order.fault.name}, {order.phase}: {result.outcome}, exit {result.code}, "
        f"{result.gates} gates, {'armed' if result.armed else 'down'}, {result.wall_s:.0f} s: "
        f"{state} | {result.said}",
        flush=True,
    )
    return row


def table(rows: Sequence[Row]) -> Iterator[str]:
    """Yield the lines of a table."""
    yield "| fault | begins | ended | exit | gates | vehicle | log | said |"
    yield "|---|---|---|---|---|---|---|---|"
    for (fault, phase, *_), result in rows:
        vehicle = "armed" if result.armed else "down" if result.vehicle_ran else "ended"
        if fault.name == "companion killed":
            code, outcome = "killed", ""
        else:
            code, outcome = str(result.code), result.outcome
        whole = "whole" if result.log_whole else "none"
        said = result.said.replace("|", "/")[:SAID_CHARACTERS]
        yield (
            f"| {fault.name} | {phase} | {outcome} | {code} | {result.gates} | {vehicle} | "
            f"{whole} | {said} |"
        )


def write(options: argparse.Namespace, lines: Sequence[str]) -> None:
    """Put a table into the document, between its marks."""
    pace = "real time" if options.real_time else "lockstep"
    table_name = f"{options.what}, {pace}" + (", whole courses" if options.duration > 12 else "")
    begin, finish = f"<!-- {table_name} -->\n", f"<!-- end of {table_name} -->"
    git = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(git, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    command = f"python scripts/bench/reliability.py {options.what}"
    command += " --real-time" if options.real_time else ""
    command += f" --phase {' '.join(options.phase)}" if options.phase else ""
    command += f" --duration {options.duration:g}" if options.duration > 12 else ""
    when = f"`{command}` at {commit.strip()}, {datetime.now(UTC):%Y-%m-%d}:"
    text = DOCUMENT.read_text()
    before, _, rest = text.partition(begin)
    after = rest.partition(finish)[2]
    DOCUMENT.write_text("\n".join([before + begin, when, "", *lines, "", finish]) + after)


def main() -> int:
    """Fly all, say how they ended; 1 if anything was not as it must be."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("faults", "links", "kills"))
    parser.add_argument("--only", nargs="+", metavar="NAME")
    parser.add_argument("--phase", nargs="+", choices=PHASES)
    parser.add_argument("--real-time", action="store_true")
    parser.add_argument("--duration", type=float, default=12.0, help="s in OFFBOARD (12)")
    parser.add_argument("--count", type=int, default=100, help="of kills and stops (100)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    with ThreadPoolExecutor(options.jobs) as pool:
        rows = list(pool.map(lambda order: flown(order, options), orders(options)))
    bad = [row for row in rows if row.wrong()]
    print(f"{len(rows)} flights, {len(bad)} not as they must be")
    if options.write:
        write(options, list(table(rows)))
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
