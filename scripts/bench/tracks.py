"""Fly one model over many unseen tracks, and print how many gates it passes on each.

Every flight is `scripts/fly --fast --json`: two processes in lockstep over real sockets. The seeds
come from the range that is kept for tests: no training and no choice of settings has seen them.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

LAUNCHER = Path(__file__).resolve().parent.parent / "fly_course.py"
FIRST_SEED = 100  # seeds from 0 on are flown by hand and by the other tests


def main() -> int:
    """Fly them all; the exit code is 1 where the mean stays below --least."""
    options = _parse_arguments()
    print(f"{'track':>6} {'gates':>7} {'outcome':<12} {'time':>8} {'real time':>10}")
    gates = []
    started = time.monotonic()
    for seed in range(options.first_seed, options.first_seed + options.tracks):
        result = _fly(options, seed)
        gates.append(result["gates_passed"])
        print(
            f"{seed:>6} {result['gates_passed']:>3}/{result['gates_total']:<3} "
            f"{result['outcome']:<12} {result['duration_s']:>6.1f} s "
            f"{result['real_time_factor']:>8.1f} x",
            flush=True,
        )
    mean = statistics.mean(gates)
    full = sum(passed == result["gates_total"] for passed in gates)
    print(
        f"{result['model']} {result['strategy']}, noise {options.noise}: mean {mean:.2f} of "
        f"{result['gates_total']} gates, {full} of {len(gates)} courses whole, "
        f"{time.monotonic() - started:.0f} s"
    )
    return 0 if mean >= options.least else 1


def _parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tracks", type=int, default=12, help="how many (default 12)")
    parser.add_argument("--first-seed", type=int, default=FIRST_SEED)
    parser.add_argument("--laps", type=int, default=4, help="the paper's mission (default 4)")
    parser.add_argument("--noise", default="1.0,2.0", metavar="GRN,GHN")
    parser.add_argument("--model", default="strong/m0")
    parser.add_argument("--strategy", default="de-mean")
    parser.add_argument("--least", type=float, default=0.0, help="mean gates wanted")
    return parser.parse_args()


def _fly(options: argparse.Namespace, seed: int) -> dict[str, Any]:
    command = [
        *(sys.executable, str(LAUNCHER), "--fast", "--json"),
        *(f"--laps={options.laps}", f"--noise={options.noise}", f"--track-seed={seed}"),
        *(f"--model={options.model}", f"--strategy={options.strategy}"),
    ]
    flown = subprocess.run(command, capture_output=True, text=True, check=False)
    last_line = flown.stdout.rstrip().rpartition("\n")[2]
    if not last_line.startswith("{"):
        sys.exit(f"track {seed}: the flight gave no result: {flown.stderr.strip()[-300:]}")
    result: dict[str, Any] = json.loads(last_line)
    return result


if __name__ == "__main__":
    sys.exit(main())
