"""Run an experiment as a command requests: fly what is missing, write the results, print them."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.markdown import Markdown

from flightstack.errors import UsageError
from flightstack.evaluation.campaign import ray_backend
from flightstack.evaluation.campaign.flying import fly, models_of
from flightstack.evaluation.campaign.folder import ROWS, Folder, read_trials
from flightstack.evaluation.campaign.options import jobs_of, px4_of
from flightstack.evaluation.campaign.workers import RAY
from flightstack.evaluation.campaign.write_errors import write_errors_as_usage
from flightstack.evaluation.pictures.gallery import Draw, draw_all
from flightstack.evaluation.results import writing
from flightstack.evaluation.results.summary import ExperimentSummary, Pair, summarise
from flightstack.evaluation.trials.experiment import Experiment
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.evaluation.trials.user_code import code_of
from flightstack.libraries import MissingLibraryError

NO_PICTURES: Mapping[str, Draw] = {}
ON_PX4 = "--autopilot=px4"
SHOWN = 2  # sections on the terminal: the title and the first table


def run_experiment(
    experiment: Experiment,
    options: argparse.Namespace,
    sections: Callable[[ExperimentSummary], list[str]],
    pairs: Sequence[Pair] | None = None,
    pictures: Mapping[str, Draw] = NO_PICTURES,
) -> ExperimentSummary:
    """Fly what is missing, or nothing for a report, and sum up.

    `pairs` are the rows whose differences are told, all where it is None; `pictures` are drawn
    beside those that every experiment has. Raises UsageError, ModelError, or UnflownError where
    trials died in every attempt.
    """
    experiment = _on_its_autopilot(experiment, options)
    if options.report_only:
        rows = read_trials(options.out, experiment)
    else:
        rows = fly_missing(experiment, options.out, options, keep_logs=options.keep_logs)
    if not rows:
        raise UsageError(f"{options.out / ROWS} holds no trial yet")
    summary = summarise(rows, pairs)
    console = Console(highlight=False)
    with write_errors_as_usage():
        written = sections(summary)
        writing.write(options.out, summary, written)
        try:
            written.append(draw_all(options.out, summary, rows, pictures))
            writing.write(options.out, summary, written)
        except MissingLibraryError as error:  # the figures stand without it
            console.print(f"no pictures: {error}", soft_wrap=True, markup=False)
    console.print(Markdown("\n".join(written[:SHOWN])))
    console.print(f"wrote {options.out / writing.MARKDOWN_FILE}", soft_wrap=True, markup=False)
    return summary


def fly_missing(
    experiment: Experiment, path: Path, options: argparse.Namespace, *, keep_logs: bool
) -> list[TrialRow]:
    """Fly what the folder at `path` lacks; returns all rows, in order.

    Nothing is written before it is clear that all can be flown. Raises as `run_experiment` does.
    """
    experiment = _on_its_autopilot(experiment, options)
    px4 = px4_of(options)
    jobs = jobs_of(options)
    if options.backend == RAY:
        ray_backend.check_installed()
    folder = Folder(path, experiment, models_of(experiment), code_of(experiment))
    return fly(experiment, folder, jobs=jobs, backend=options.backend, keep_logs=keep_logs, px4=px4)


def _on_its_autopilot(experiment: Experiment, options: argparse.Namespace) -> Experiment:
    """Say in an experiment that a real PX4 flies it, so that its rows stay apart from others."""
    if options.autopilot != "px4" or ON_PX4 in experiment.conditions[0].vehicle_options:
        return experiment
    conditions = tuple(
        replace(condition, vehicle_options=(*condition.vehicle_options, ON_PX4))
        for condition in experiment.conditions
    )
    return replace(experiment, conditions=conditions)
