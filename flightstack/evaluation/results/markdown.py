"""Write a summary as Markdown tables; any experiment's."""

from collections.abc import Callable, Iterable, Sequence

from flightstack.evaluation.results.statistics import NO_SPREAD, MeanEstimate
from flightstack.evaluation.results.summary import Cell, ExperimentSummary

SURVIVAL_AT = (1, 2, 4, 8, 16, 24, 32)  # gates


def table(header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Write one table; all but the first column are aligned right."""
    rule = ["---", *["---:"] * (len(header) - 1)]
    return "".join(f"| {' | '.join(line)} |\n" for line in (header, rule, *lines))


def figure(estimate: MeanEstimate, form: str = ".2f") -> str:
    """Write a mean and its interval; a star marks one without spread."""
    mean = format(estimate.mean, form)
    if estimate.low is None or estimate.high is None:
        return mean
    star = "\\*" if estimate.method == NO_SPREAD else ""
    return f"{mean} [{format(estimate.low, form)}, {format(estimate.high, form)}]{star}"


def cells(summary: ExperimentSummary, text: Callable[[Cell], str]) -> str:
    """Write one table of a figure of each cell: rows by conditions."""
    return table(
        ["row", *summary.conditions],
        (
            [row, *(_of(summary, row, condition, text) for condition in summary.conditions)]
            for row in summary.rows
        ),
    )


def common_sections(summary: ExperimentSummary) -> list[str]:
    """Write what every experiment tells after its own first table, each with its heading."""
    return [
        "## Whole courses\n\n" + cells(summary, lambda cell: figure(cell.full, ".0%")),
        "## Mean speed, m/s\n\n" + cells(summary, lambda cell: figure(cell.speed_m_s)),
        "## How trials ended\n\n" + cells(summary, outcomes),
        *differences(summary),
        "## Share of trials that passed at least so many gates\n\n" + survival(summary),
        footnotes(summary),
    ]


def differences(summary: ExperimentSummary) -> list[str]:
    """Write the paired differences, where there are any."""
    header = ["row - row", "condition", "gates", "whole courses", "mean speed, m/s"]
    lines = [
        [
            f"{one.row} - {one.minus}",
            one.condition,
            figure(one.gates, "+.2f"),
            figure(one.full, "+.0%"),
            figure(one.speed_m_s, "+.2f"),
        ]
        for one in summary.differences
    ]
    return ["## Differences on the same tracks\n\n" + table(header, lines)] if lines else []


def survival(summary: ExperimentSummary) -> str:
    """Write some points of the survival curves."""
    gates_total = max(cell.gates_total for cell in summary.cells)
    at = [gate for gate in SURVIVAL_AT if gate <= gates_total]
    return table(
        ["row", "condition", *map(str, at)],
        (
            [cell.row, cell.condition, *(_survived(cell, gate) for gate in at)]
            for cell in summary.cells
        ),
    )


def footnotes(summary: ExperimentSummary) -> str:
    """Say how the figures came about."""
    retries = sum(cell.retries for cell in summary.cells)
    weights = "\n".join(f"- `{name}`: `{hash_}`" for name, hash_ in summary.weights.items())
    counts = sorted({cell.trials for cell in summary.cells})
    gaps = "" if len(counts) == 1 else f" **Not complete: {counts[0]} to {counts[-1]} a cell.**"
    return (
        f"In brackets: {summary.confidence:.0%} intervals by BCa bootstrap over tracks "
        f"({summary.resamples} resamples; exact where all courses, or none, were whole; \\* where "
        f"all tracks gave the same, which tells no interval). {summary.trials} trials on tracks "
        f"{summary.tracks[0]} to {summary.tracks[-1]}, commit {', '.join(summary.commits)}; "
        f"{retries} flights died and were flown again.{gaps}\n\nWeights (SHA-256):\n\n{weights}\n"
    )


def _of(summary: ExperimentSummary, row: str, condition: str, text: Callable[[Cell], str]) -> str:
    cell = summary.cell(row, condition)
    return "" if cell is None else text(cell)


def outcomes(cell: Cell) -> str:
    """Say how often a cell's trials ended which way."""
    return ", ".join(
        f"{count} {outcome.replace('_', ' ')}" for outcome, count in cell.outcomes.items()
    )


def _survived(cell: Cell, gate: int) -> str:
    return f"{cell.survival.share[gate - 1]:.0%}" if gate <= cell.gates_total else ""
