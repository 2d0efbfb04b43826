"""Draw all pictures of an experiment from its rows and traces, and name them in its results."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from flightstack.evaluation.campaign.folder import TRACES
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.pictures.birds_eye import Way, draw_birds_eye
from flightstack.evaluation.pictures.differences import draw_differences
from flightstack.evaluation.pictures.style import save
from flightstack.evaluation.pictures.survival import draw_survival
from flightstack.evaluation.results.summary import ExperimentSummary
from flightstack.evaluation.trials.rows import TrialRow, by_cell

FOLDER = "pictures"
Draw = Callable[[ExperimentSummary], Any]  # returns a figure


def draw_all(
    out: Path, summary: ExperimentSummary, rows: Sequence[TrialRow], own: Mapping[str, Draw]
) -> str:
    """Draw into `out` what every experiment has, and its own by name; return the section on them.

    Raises MissingLibraryError without matplotlib, UsageError where a trace is damaged.
    """
    folder = out / FOLDER
    folder.mkdir(exist_ok=True)
    drawn = dict(own)
    drawn["survival"] = draw_survival
    if summary.differences:
        drawn["differences"] = draw_differences
    ways = find_ways(out / TRACES, rows)
    if ways:
        drawn["birds-eye"] = lambda _: draw_birds_eye(ways)
    for name, draw in drawn.items():
        save(draw(summary), folder / f"{name}.png")
    return "## Pictures\n\n" + "".join(f"![{name}]({FOLDER}/{name}.png)\n" for name in drawn)


def find_ways(folder: Path, rows: Sequence[TrialRow]) -> dict[tuple[str, str], list[Way]]:
    """Load the traces of these rows by cell; a row whose trace is missing is left out."""
    found: dict[tuple[str, str], list[Way]] = {}
    for cell, own in by_cell(rows).items():
        for row in own:
            path = folder / f"{'-'.join(map(str, row.key))}.npz"
            if path.exists():
                found.setdefault(cell, []).append(Way(Trace.load(path), row.is_full))
    return found
