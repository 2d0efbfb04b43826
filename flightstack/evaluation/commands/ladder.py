"""Fly the ladder: noise, haste, late, bad and frozen images, fog, darkness, wind, second gates."""

import argparse

from flightstack.evaluation.experiments.options import add_flying_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--model", nargs="+", default=["strong/m0"], help="one or more (default: strong/m0)")
    add("--strategy", nargs="+", default=[], help="one or more (default: each model's own)")
    add("--rungs", nargs="+", default=[], metavar="RUNG", help="names or TOML files (default: all)")
    add_flying_options(parser, tracks=24)


def run(options: argparse.Namespace) -> None:
    """Fly what is missing, then write and print the results."""
    # Here, not above: --help must not wait for scipy and torch.
    from flightstack.evaluation.experiments.competitors import make_rows  # noqa: PLC0415
    from flightstack.evaluation.experiments.conducting import conduct  # noqa: PLC0415
    from flightstack.evaluation.experiments.experiment import Experiment, tracks  # noqa: PLC0415
    from flightstack.evaluation.experiments.folder import ROWS  # noqa: PLC0415
    from flightstack.evaluation.experiments.rows import read_rows  # noqa: PLC0415
    from flightstack.evaluation.ladder.report import ladder_sections  # noqa: PLC0415
    from flightstack.evaluation.ladder.rungs import known_rungs, load_rung  # noqa: PLC0415
    from flightstack.evaluation.pictures.ladder import draw_ladder  # noqa: PLC0415
    from flightstack.evaluation.results.summary import Summary  # noqa: PLC0415

    rungs = [load_rung(name) for name in options.rungs or known_rungs()]
    about = {condition.name: rung.about for rung, condition in rungs}
    experiment = Experiment(
        name="ladder",
        rows=make_rows(options.model, options.strategy),
        conditions=tuple(condition for _, condition in rungs),
        track_seeds=tracks(options.tracks, options.seeds),
        trials=options.trials,
        laps=options.laps,
    )

    def sections(summary: Summary) -> list[str]:
        return ladder_sections(summary, read_rows(options.out / ROWS), about, "The ladder")

    conduct(experiment, options, sections, pictures={"ladder": draw_ladder})
