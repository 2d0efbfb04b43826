"""Fly the paper's Table II: six rows at two levels of noise, with intervals."""

import argparse
from typing import TYPE_CHECKING

from flightstack.evaluation.campaign.options import add_flying_options

if TYPE_CHECKING:
    from flightstack.evaluation.trials.experiment import Experiment

NAME = "table"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--recipe", default="paper", metavar="NAME", help="whose models (default: paper)")
    add("--rows", nargs="+", metavar="ROW", help="such as m0-mi-mode m0-mean (default: all six)")
    add("--levels", nargs="+", default=["1", "2"], metavar="LEVEL", help="1, 2, or noise GRN,GHN")
    add_flying_options(parser)


def run(options: argparse.Namespace) -> None:
    """Fly what is missing, then write and print the results."""
    # Here, not above: --help must not wait for scipy and torch.
    from flightstack.evaluation.results.writing import table_sections  # noqa: PLC0415
    from flightstack.evaluation.run import run_experiment  # noqa: PLC0415
    from flightstack.evaluation.trials import paper  # noqa: PLC0415
    from flightstack.evaluation.trials.experiment import Experiment, tracks  # noqa: PLC0415
    from flightstack.evaluation.trials.resume import resume  # noqa: PLC0415

    levels = tuple(paper.level(text) for text in options.levels)
    if options.report_only:
        options.levels = [level.name for level in levels]
        experiment = resume(options, NAME, _options_of)
    else:
        experiment = Experiment(
            name=NAME,
            rows=paper.rows(options.recipe, tuple(options.rows or paper.MEAN_GATES)),
            conditions=levels,
            track_seeds=tracks(options.tracks, options.seeds),
            trials=options.trials,
            laps=options.laps,
        )
    run_experiment(experiment, options, table_sections)


def _options_of(held: "Experiment") -> dict[str, list[str]]:
    return {
        "recipe": [row.model.partition("/")[0] for row in held.rows],
        "rows": [row.name for row in held.rows],
        "levels": [condition.name for condition in held.conditions],
    }
