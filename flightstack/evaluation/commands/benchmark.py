"""Fly your own policy, perception or strategy on the same tracks as the models that come along."""

import argparse
from typing import TYPE_CHECKING

from flightstack.evaluation.campaign.options import add_flying_options

if TYPE_CHECKING:
    from flightstack.evaluation.trials.experiment import Condition, Experiment

NAME = "benchmark"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the options."""
    add = parser.add_argument
    add("--policy", metavar="NAME", help="yours: my_package:MyPolicy (docs/bring-your-own.md)")
    add("--perception", metavar="NAME", help="yours: my_package:MyPerception")
    add("--strategy", metavar="NAME", help="yours, or a known one (default: the model's)")
    add("--pilot", metavar="NAME", help="yours in place of all: from image to velocities")
    add("--model", default="strong/m0", help="whose other parts fly with yours (strong/m0)")
    add("--against", nargs="*", metavar="MODEL", help="models beside yours (default: --model's)")
    add(
        *("--rungs",),
        nargs="+",
        default=["level1", "level2"],
        metavar="RUNG",
        help="names or TOML files (default: level1 level2)",
    )
    add_flying_options(parser, tracks=24)


def run(options: argparse.Namespace) -> None:
    """Fly what is missing, then write and print the results."""
    # Here, not above: --help must not wait for scipy and torch.
    from flightstack.evaluation.results.writing import plain_sections  # noqa: PLC0415
    from flightstack.evaluation.run import run_experiment  # noqa: PLC0415
    from flightstack.evaluation.trials.resume import resume  # noqa: PLC0415
    from flightstack.evaluation.trials.rungs import load_rung  # noqa: PLC0415

    conditions = tuple(load_rung(name)[1] for name in options.rungs)
    if options.report_only:
        options.rungs = [condition.name for condition in conditions]
        experiment = resume(options, NAME, _options_of)
    else:
        experiment = _request(options, conditions)
    title = f"Benchmark, {experiment.rows[0].name}"
    run_experiment(experiment, options, lambda summary: plain_sections(summary, title))


def _request(options: argparse.Namespace, conditions: tuple["Condition", ...]) -> "Experiment":
    """Put what the user brings first."""
    from flightstack.errors import UsageError  # noqa: PLC0415
    from flightstack.evaluation.trials.competitors import (  # noqa: PLC0415
        make_competitors,
        make_pilots_competitor,
        make_users_competitor,
    )
    from flightstack.evaluation.trials.experiment import Experiment, tracks  # noqa: PLC0415

    parts = (options.perception, options.policy, options.strategy)
    if options.pilot is not None:
        if any(parts):
            raise UsageError("--pilot: it takes no --policy, --perception or --strategy beside it")
        own = make_pilots_competitor(options.pilot)
    elif any(parts):
        own = make_users_competitor(
            options.model, options.strategy, perception=options.perception, policy=options.policy
        )
    else:
        raise UsageError("name your own part: --policy, --perception, --strategy or --pilot")
    against = [options.model] if options.against is None else options.against
    return Experiment(
        name=NAME,
        rows=(own, *make_competitors(against, [])),
        conditions=conditions,
        track_seeds=tracks(options.tracks, options.seeds),
        trials=options.trials,
        laps=options.laps,
    )


def _options_of(held: "Experiment") -> dict[str, list[str]]:
    own, *others = held.rows
    users = dict(text.removeprefix("--").split("=", 1) for text in own.companion_options)
    brought = ("perception", "policy", "pilot")
    models = {} if own.pilot is not None else {"strategy": [own.strategy], "model": [own.model]}
    return {
        **{part: [users[part]] if part in users else [] for part in brought},
        **models,
        "against": [row.model for row in others],
        "rungs": [condition.name for condition in held.conditions],
    }
