"""What an ablation answers in one condition: the effect of mi-mode, split, and beside controls."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from flightstack.evaluation.ablation.design import FACTORS, Point, corner, cube
from flightstack.evaluation.ablation.effects import main_effects, one_at_a_time, shares
from flightstack.evaluation.ablation.pace import Control
from flightstack.evaluation.results.statistics import MeanEstimate, difference_over
from flightstack.evaluation.trials.rows import TrialRow, by_cell, by_track

MEASURES = ("gates_passed", "is_full")
ByTrack = Mapping[int, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """What a strategy changes against another, on the same tracks."""

    strategy: str
    minus: str
    gates: MeanEstimate
    full: MeanEstimate
    speed_m_s: MeanEstimate  # flown: how well a control's pace is met


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionAnswer:
    """One condition's answer; tables by measure (gates_passed, is_full), then by factor."""

    condition: str
    whole: Comparison  # mi-mode against de-mean
    shares: dict[str, dict[str, MeanEstimate]]  # of the three factors; they add up to the whole
    added: dict[str, dict[str, MeanEstimate]]  # each alone to de-mean
    lost: dict[str, dict[str, MeanEstimate]]  # each alone from mi-mode
    main: dict[str, dict[str, MeanEstimate]]  # "factor: level", where all combinations were flown
    pace_alone: Comparison  # mi-mode's control against de-mean
    controls: tuple[Comparison, ...]  # each strategy against its control


@dataclass(frozen=True, slots=True, kw_only=True)
class Ablation:
    """All answers, and how the controls came about."""

    controls: tuple[Control, ...]
    answers: tuple[ConditionAnswer, ...]


def answer(
    rows: Sequence[TrialRow], points: Sequence[Point], controls: Mapping[str, Control]
) -> Ablation:
    """Answer for every condition that all strategies were flown in."""
    cells: dict[str, dict[str, Sequence[TrialRow]]] = {}
    for (_, condition), own in by_cell(rows).items():
        cells.setdefault(condition, {})[own[0].strategy] = own
    return Ablation(
        controls=tuple(controls.values()),
        answers=tuple(
            _answer(condition, own, points, controls)
            for condition, own in cells.items()
            if _needed(points, controls) <= own.keys()
        ),
    )


def _needed(points: Iterable[Point], controls: Mapping[str, Control]) -> set[str]:
    return {point.strategy for point in points} | {one.rule for one in controls.values()}


def _answer(
    condition: str,
    cells: Mapping[str, Sequence[TrialRow]],
    points: Sequence[Point],
    controls: Mapping[str, Control],
) -> ConditionAnswer:
    plain, papers = corner(()).strategy, corner(FACTORS).strategy
    values = {
        measure: {point: by_track(cells[point.strategy], measure) for point in points}
        for measure in MEASURES
    }
    alone = {measure: one_at_a_time(own) for measure, own in values.items()}
    return ConditionAnswer(
        condition=condition,
        whole=_against(cells, papers, plain),
        shares={measure: shares(own) for measure, own in values.items()},
        added={m: {factor: own[0] for factor, own in found.items()} for m, found in alone.items()},
        lost={m: {factor: own[1] for factor, own in found.items()} for m, found in alone.items()},
        main={m: _main(own) for m, own in values.items()} if len(points) > len(cube()) else {},
        pace_alone=_against(cells, controls[papers].rule, plain),
        controls=tuple(
            _against(cells, point.strategy, controls[point.strategy].rule)
            for point in points
            if point.strategy != plain
        ),
    )


def _main(values: Mapping[Point, ByTrack]) -> dict[str, MeanEstimate]:
    return {f"{factor}: {level}": own for (factor, level), own in main_effects(values).items()}


def _against(cells: Mapping[str, Sequence[TrialRow]], strategy: str, minus: str) -> Comparison:
    gates, full, speed_m_s = (
        difference_over(by_track(cells[strategy], measure), by_track(cells[minus], measure))
        for measure in (*MEASURES, "mean_speed_m_s")
    )
    return Comparison(strategy=strategy, minus=minus, gates=gates, full=full, speed_m_s=speed_m_s)
