"""Sum up rows: each cell of a table, and the paired differences between its rows."""

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flightstack.evaluation.results.statistics import (
    CONFIDENCE,
    RESAMPLES,
    MeanEstimate,
    difference_over,
    mean_over,
    share_over,
    survival_over,
)
from flightstack.evaluation.trials.rows import TrialRow, by_cell, by_track

Pair = tuple[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Survival:
    """Share of trials that passed at least 1, 2, ... gates, with a pointwise band."""

    share: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One row in one condition."""

    row: str
    condition: str
    model: str
    strategy: str
    command_factor: float
    trials: int
    gates_total: int
    gates: MeanEstimate
    full: MeanEstimate  # share of whole courses
    speed_m_s: MeanEstimate
    outcomes: dict[str, int]
    retries: int
    survival: Survival


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """How much more `row` has than `minus`, on the same tracks."""

    condition: str
    row: str
    minus: str
    gates: MeanEstimate
    full: MeanEstimate
    speed_m_s: MeanEstimate


@dataclass(frozen=True, slots=True, kw_only=True)
class ExperimentSummary:
    """All that is said of an experiment, from its rows alone."""

    experiment: str
    tracks: tuple[int, ...]
    trials: int  # in all
    commits: tuple[str, ...]
    weights: dict[str, str]  # SHA-256 by model
    confidence: float
    resamples: int
    cells: tuple[Cell, ...]
    differences: tuple[Difference, ...]

    def cell(self, row: str, condition: str) -> Cell | None:
        """Find a cell."""
        found = (c for c in self.cells if (c.row, c.condition) == (row, condition))
        return next(found, None)

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows, in order."""
        return tuple(dict.fromkeys(cell.row for cell in self.cells))

    @property
    def conditions(self) -> tuple[str, ...]:
        """Names of the conditions, in order."""
        return tuple(dict.fromkeys(cell.condition for cell in self.cells))


def summarise(rows: Sequence[TrialRow], pairs: Sequence[Pair] | None = None) -> ExperimentSummary:
    """Sum up rows, in their order; differences of these pairs, or of all."""
    cells = by_cell(rows)
    if pairs is None:
        pairs = list(itertools.combinations(dict.fromkeys(row for row, _ in cells), 2))
    conditions = dict.fromkeys(condition for _, condition in cells)
    return ExperimentSummary(
        experiment=rows[0].experiment,
        tracks=tuple(sorted({row.track_seed for row in rows})),
        trials=len(rows),
        commits=tuple(sorted({row.commit for row in rows})),
        weights={row.model: row.weights_sha256 for row in rows},
        confidence=CONFIDENCE,
        resamples=RESAMPLES,
        cells=tuple(_cell(own) for own in cells.values()),
        differences=tuple(
            _difference(cells[first, condition], cells[second, condition])
            for condition in conditions
            for first, second in pairs
            if (first, condition) in cells and (second, condition) in cells
        ),
    )


def _cell(rows: Sequence[TrialRow]) -> Cell:
    one = rows[0]
    return Cell(
        row=one.row,
        condition=one.condition,
        model=one.model,
        strategy=one.strategy,
        command_factor=one.command_factor,
        trials=len(rows),
        gates_total=one.gates_total,
        gates=mean_over(list(by_track(rows, "gates_passed").values())),
        full=share_over(list(by_track(rows, "is_full").values())),
        speed_m_s=mean_over(list(by_track(rows, "mean_speed_m_s").values())),
        outcomes=dict(sorted(Counter(row.outcome for row in rows).items())),
        retries=sum(row.retries for row in rows),
        survival=_survival(rows),
    )


def _survival(rows: Sequence[TrialRow]) -> Survival:
    passed: dict[int, list[int]] = {}
    for row in rows:
        passed.setdefault(row.track_seed, []).append(row.gates_passed)
    curves: list[Any] = [
        tuple(curve.tolist()) for curve in survival_over(list(passed.values()), rows[0].gates_total)
    ]
    return Survival(share=curves[0], low=curves[1], high=curves[2])


def _difference(first: Sequence[TrialRow], second: Sequence[TrialRow]) -> Difference:
    def over(value: str) -> MeanEstimate:
        return difference_over(by_track(first, value), by_track(second, value))

    return Difference(
        condition=first[0].condition,
        row=first[0].row,
        minus=second[0].row,
        gates=over("gates_passed"),
        full=over("is_full"),
        speed_m_s=over("mean_speed_m_s"),
    )
