"""Conduct an experiment as a command asks: fly what is missing, write the results, print them."""

import argparse
from collections.abc import Callable, Mapping, Sequence

from rich.console import Console
from rich.markdown import Markdown

from flightstack.errors import UsageError
from flightstack.evaluation.experiments.brought_code import code_of
from flightstack.evaluation.experiments.experiment import Experiment
from flightstack.evaluation.experiments.flying import fly, models_of
from flightstack.evaluation.experiments.folder import ROWS, Folder
from flightstack.evaluation.experiments.options import jobs_of
from flightstack.evaluation.experiments.rows import TrialRow, read_rows
from flightstack.evaluation.pictures.gallery import Draw, draw_all
from flightstack.evaluation.results import writing
from flightstack.evaluation.results.summary import Pair, Summary, summarise

NO_PICTURES: Mapping[str, Draw] = {}
SHOWN = 2  # sections on the terminal: the title and the first table


def conduct(
    experiment: Experiment,
    options: argparse.Namespace,
    sections: Callable[[Summary], list[str]],
    pairs: Sequence[Pair] | None = None,
    pictures: Mapping[str, Draw] = NO_PICTURES,
) -> Summary:
    """Fly and sum up; `pairs` are the rows whose differences are told, all where it is None.

    `pictures` are drawn beside those that every experiment has. Raises UsageError, ModelError, or
    UnflownError where trials died in every attempt.
    """
    rows = _rows(experiment, options)
    summary = summarise(rows, pairs)
    written = sections(summary)
    writing.write(options.out, summary, written)
    console = Console(highlight=False)
    try:
        written.append(draw_all(options.out, summary, rows, pictures))
        writing.write(options.out, summary, written)
    except UsageError as error:  # the figures stand without it
        console.print(f"no pictures: {error}", soft_wrap=True, markup=False)
    console.print(Markdown("\n".join(written[:SHOWN])))
    console.print(f"wrote {options.out / writing.MARKDOWN_FILE}", soft_wrap=True, markup=False)
    return summary


def _rows(experiment: Experiment, options: argparse.Namespace) -> list[TrialRow]:
    if options.report_only:
        rows = read_rows(options.out / ROWS)
        if not rows:
            raise UsageError(f"{options.out / ROWS} holds no trial yet")
        if rows[0].experiment != experiment.name:
            raise UsageError(f"{options.out / ROWS} is of a {rows[0].experiment}")
        return rows
    jobs = jobs_of(options)
    folder = Folder(options.out, experiment, models_of(experiment), code_of(experiment))
    return fly(experiment, folder, jobs=jobs, backend=options.backend, keep_logs=options.keep_logs)
