"""Tell of a ladder: a line per rung, a column per row, and what a rung costs on the same tracks."""

from collections.abc import Callable, Mapping, Sequence

from flightstack.evaluation.results.markdown import (
    differences,
    figure,
    footnotes,
    outcomes,
    survival,
    table,
)
from flightstack.evaluation.results.statistics import MeanEstimate, difference_over
from flightstack.evaluation.results.summary import Cell, ExperimentSummary
from flightstack.evaluation.trials.rows import TrialRow, by_cell, by_track

STANDS_ON = "level2"  # what most rungs add one trouble to


def ladder_sections(
    summary: ExperimentSummary, rows: Sequence[TrialRow], about: Mapping[str, str], title: str
) -> list[str]:
    """Write all; `about` says what each rung is."""
    gates = summary.cells[0].gates_total
    costs = rung_costs(rows)
    return [
        f"# {title}\n",
        f"## Gates passed, of {gates}\n\n" + by_rung(summary, lambda cell: figure(cell.gates)),
        "## Whole courses\n\n" + by_rung(summary, lambda cell: figure(cell.full, ".0%")),
        "## Mean speed, m/s\n\n" + by_rung(summary, lambda cell: figure(cell.speed_m_s)),
        *(
            [f"## Gates against {STANDS_ON}, on the same tracks\n\n" + _costs(costs)]
            if costs
            else []
        ),
        "## How trials ended\n\n" + by_rung(summary, outcomes),
        *differences(summary),
        "## Share of trials that passed at least so many gates\n\n" + survival(summary),
        "## Rungs\n\n" + "".join(f"- **{name}**: {text}\n" for name, text in about.items()),
        footnotes(summary),
    ]


def by_rung(summary: ExperimentSummary, text: Callable[[Cell], str]) -> str:
    """Write one table of a figure of each cell: rungs by rows."""
    lines = []
    for condition in summary.conditions:
        cells = [summary.cell(row, condition) for row in summary.rows]
        lines.append([condition, *("" if cell is None else text(cell) for cell in cells)])
    return table(["rung", *summary.rows], lines)


def rung_costs(rows: Sequence[TrialRow]) -> dict[tuple[str, str], MeanEstimate]:
    """Subtract the gates on STANDS_ON from those on each rung, by (row, rung), paired by track."""
    cells = by_cell(rows)
    return {
        (row, rung): difference_over(
            by_track(own, "gates_passed"), by_track(cells[row, STANDS_ON], "gates_passed")
        )
        for (row, rung), own in cells.items()
        if rung != STANDS_ON and (row, STANDS_ON) in cells
    }


def _costs(costs: Mapping[tuple[str, str], MeanEstimate]) -> str:
    rows = list(dict.fromkeys(row for row, _ in costs))
    rungs = list(dict.fromkeys(rung for _, rung in costs))
    return table(
        ["rung", *rows],
        (
            [
                rung,
                *(figure(costs[row, rung], "+.2f") if (row, rung) in costs else "" for row in rows),
            ]
            for rung in rungs
        ),
    )
