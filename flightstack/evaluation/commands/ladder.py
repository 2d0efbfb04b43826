"""Fly the ladder: noise, haste, late, bad and frozen images, fog, darkness, wind, second gates."""

import argparse
from typing import TYPE_CHECKING

from flightstack.evaluation.campaign.options import add_flying_options

if TYPE_CHECKING:
    from flightstack.evaluation.trials.experiment import Experiment

NAME = "ladder"


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
    from flightstack.evaluation.campaign.folder import read_trials  # noqa: PLC0415
    from flightstack.evaluation.pictures.ladder import draw_ladder  # noqa: PLC0415
    from flightstack.evaluation.results.ladder import ladder_sections  # noqa: PLC0415
    from flightstack.evaluation.results.summary import ExperimentSummary  # noqa: PLC0415
    from flightstack.evaluation.run import run_experiment  # noqa: PLC0415
    from flightstack.evaluation.trials.competitors import make_competitors  # noqa: PLC0415
    from flightstack.evaluation.trials.experiment import Experiment, tracks  # noqa: PLC0415
    from flightstack.evaluation.trials.resume import resume  # noqa: PLC0415
    from flightstack.evaluation.trials.rungs import known_rungs, load_rung  # noqa: PLC0415

    rungs = [load_rung(name) for name in options.rungs or known_rungs()]
    about = {condition.name: rung.about for rung, condition in rungs}
    if options.report_only:
        options.rungs = list(about)
        experiment = resume(options, NAME, _options_of)
    else:
        experiment = Experiment(
            name=NAME,
            rows=make_competitors(options.model, options.strategy),
            conditions=tuple(condition for _, condition in rungs),
            track_seeds=tracks(options.tracks, options.seeds),
            trials=options.trials,
            laps=options.laps,
        )

    def sections(summary: ExperimentSummary) -> list[str]:
        flown = {name: about[name] for name in summary.conditions if name in about}
        return ladder_sections(summary, read_trials(options.out, experiment), flown, "The ladder")

    run_experiment(experiment, options, sections, pictures={"ladder": draw_ladder})


def _options_of(held: "Experiment") -> dict[str, list[str]]:
    return {
        "model": [row.model for row in held.rows],
        "strategy": [row.strategy for row in held.rows],
        "rungs": [condition.name for condition in held.conditions],
    }
