"""The options that every command shares which flies trials."""

import argparse
import os
from pathlib import Path

from flightstack.errors import UsageError

FIRST_TRACK = 1000


def add_flying_options(parser: argparse.ArgumentParser, *, tracks: int = 50) -> None:
    """Describe them; `tracks` is how many where the user names none."""
    add = parser.add_argument
    add("--tracks", type=int, default=tracks, metavar="N", help=f"(default: {tracks})")
    add("--trials", type=int, default=1, metavar="K", help="on each track (default: 1)")
    add("--seeds", type=int, default=FIRST_TRACK, metavar="FIRST", help="of the tracks (1000)")
    add("--laps", type=int, default=4, metavar="N", help="of 8 gates (default: 4)")
    add("--jobs", type=int, metavar="N", help="flights at once (default: one per core)")
    add("--backend", choices=("loky", "ray"), default="loky", help="(default: loky)")
    add("--out", type=Path, required=True, metavar="DIR", help="folder of rows and results")
    add("--autopilot", choices=("emulated", "px4"), default="emulated", help="who flies")
    add("--px4", type=Path, metavar="PATH", help="build folder or binary of a real PX4")
    add("--keep-logs", action="store_true", help="keep the companion's tlog of each trial")
    add("--report-only", action="store_true", help="make the results anew from DIR's rows")


def px4_of(options: argparse.Namespace) -> Path | None:
    """Return the real PX4 that flies, None where the emulated autopilot does. Raises UsageError."""
    px4: Path | None = options.px4
    if options.autopilot == "px4" and px4 is None and not options.report_only:
        raise UsageError("--autopilot px4 needs --px4 PATH: PX4's build folder or its binary")
    if options.autopilot != "px4" and px4 is not None:
        raise UsageError("--px4: only with --autopilot px4")
    return px4


def jobs_of(options: argparse.Namespace) -> int:
    """How many flights at once: on a Ray cluster all that it can. Raises UsageError."""
    if options.jobs is not None:
        if options.jobs == 0 or options.jobs < -1:  # -1 is joblib's for all
            raise UsageError(f"--jobs must be 1 or more, got {options.jobs}")
        return int(options.jobs)
    return -1 if options.backend == "ray" else len(os.sched_getaffinity(0))
