"""Fly the paper's Table II: six rows at two levels of noise, with intervals."""

import argparse
import os
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--recipe", default="paper", metavar="NAME", help="whose models: paper (default) or strong")
    add("--rows", nargs="+", metavar="ROW", help="such as m0-mi-mode m0-mean (default: all six)")
    add("--levels", nargs="+", default=["1", "2"], metavar="LEVEL", help="1, 2, or noise GRN,GHN")
    add_flying_arguments(parser)


def add_flying_arguments(parser: argparse.ArgumentParser, *, tracks: int = 50) -> None:
    """Describe the options that every command shares which flies trials."""
    add = parser.add_argument
    add("--tracks", type=int, default=tracks, metavar="N", help=f"(default: {tracks})")
    add("--trials", type=int, default=1, metavar="K", help="on each track (default: 1)")
    add("--seeds", type=int, default=1000, metavar="FIRST", help="first track (default: 1000)")
    add("--laps", type=int, default=4, metavar="N", help="of 8 gates (default: 4)")
    add("--jobs", type=int, metavar="N", help="flights at once (default: one a core)")
    add("--backend", choices=("loky", "ray"), default="loky", help="(default: loky)")
    add("--out", type=Path, required=True, metavar="DIR", help="folder of rows and results")
    add("--keep-logs", action="store_true", help="keep the companion's tlog of each trial")
    add("--report-only", action="store_true", help="make the results anew from the rows")


def cores() -> int:
    """Count the cores that this process may use."""
    return len(os.sched_getaffinity(0))


def run(options: argparse.Namespace) -> None:
    """Fly what is missing, then write and print the results."""
    # Here, not above: --help must not wait for scipy and torch.
    from flightstack.evaluation import paper  # noqa: PLC0415
    from flightstack.evaluation.experiment import Experiment, tracks  # noqa: PLC0415
    from flightstack.evaluation.flying import fly, weights_of  # noqa: PLC0415
    from flightstack.evaluation.folder import Folder  # noqa: PLC0415

    names = tuple(options.rows or paper.MEAN_GATES)
    experiment = Experiment(
        name="table",
        rows=paper.rows(options.recipe, names),
        conditions=tuple(paper.level(text) for text in options.levels),
        track_seeds=tracks(options.tracks, options.seeds),
        trials=options.trials,
        laps=options.laps,
    )
    folder = Folder(options.out, experiment, weights_of(experiment))
    rows = fly(
        experiment,
        folder,
        jobs=options.jobs or cores(),
        backend=options.backend,
        keep_logs=options.keep_logs,
    )
    print(len(rows))
