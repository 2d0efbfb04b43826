"""Tell what an ablation answers, as Markdown."""

from collections.abc import Mapping, Sequence

from flightstack.evaluation.ablation.answer import Ablation, Comparison, ConditionAnswer
from flightstack.evaluation.ablation.design import FACTORS, PAPERS, PLAIN
from flightstack.evaluation.results.markdown import (
    cells,
    common_sections,
    figure,
    table,
)
from flightstack.evaluation.results.statistics import MeanEstimate
from flightstack.evaluation.results.summary import ExperimentSummary

Measures = Mapping[str, Mapping[str, MeanEstimate]]


def ablation_sections(summary: ExperimentSummary, ablation: Ablation, model: str) -> list[str]:
    """Write all."""
    gates = summary.cells[0].gates_total
    answers = "\n".join(map(_parts, ablation.answers)) or "No condition is complete yet.\n"
    return [
        f"# What makes the effect of mi-mode, {model}\n",
        f"## The parts of mi-mode - de-mean, gates of {gates}\n\n{answers}\n{_explanation()}",
        "## One factor at a time\n\n" + _one_at_a_time(ablation.answers),
        *_main_effects(ablation.answers),
        "## Each strategy against the mean at the same pace\n\n" + _controls(ablation.answers),
        "## Pace on validation tracks\n\n" + _paces(ablation),
        "## Gates passed\n\n" + cells(summary, lambda cell: figure(cell.gates)),
        *common_sections(summary),
    ]


def _parts(answer: ConditionAnswer) -> str:
    def line(name: str, against: Comparison) -> list[str]:
        return [name, figure(against.gates, "+.2f"), figure(against.full, "+.0%")]

    left = next(one for one in answer.controls if one.strategy == answer.whole.strategy)
    lines = [line("**mi-mode - de-mean**", answer.whole)]
    lines += [[f"of that: {factor}", *_both(answer.shares, factor)] for factor in FACTORS]
    lines.append(
        line(f"constant slow-down to mi-mode's pace ({left.minus}) alone", answer.pace_alone)
    )
    lines.append(line("mi-mode - that", left))
    return f"### {answer.condition}\n\n" + table(["part", "gates", "whole courses"], lines)


def _explanation() -> str:
    levels = "; ".join(f"{factor}: {PLAIN[factor]} to {PAPERS[factor]}" for factor in FACTORS)
    return (
        f"The three factors ({levels}) add up to the whole: each one's share is what it changes, "
        "averaged over all orders of adding them (its Shapley value). A constant slow-down is the "
        "mean's vx times one factor, found on validation tracks so that it commands the same mean "
        "vx. All differences are on the same tracks.\n"
    )


def _one_at_a_time(answers: Sequence[ConditionAnswer]) -> str:
    added, kept = "added to de-mean, gates", "in mi-mode against without it, gates"
    header = ["condition", "factor", added, "whole courses", kept, "whole courses"]
    return table(
        header,
        (
            [
                *(answer.condition, factor),
                *_both(answer.added, factor),
                *_both(answer.lost, factor),
            ]
            for answer in answers
            for factor in FACTORS
        ),
    )


def _main_effects(answers: Sequence[ConditionAnswer]) -> list[str]:
    lines = [
        [answer.condition, name, *_both(answer.main, name)]
        for answer in answers
        if answer.main
        for name in answer.main["gates_passed"]
    ]
    if not lines:
        return []
    return [
        "## Each level against the plain one, all else averaged\n\n"
        + table(["condition", "level", "gates", "whole courses"], lines)
    ]


def _controls(answers: Sequence[ConditionAnswer]) -> str:
    return table(
        ["condition", "strategy", "control", "gates", "whole courses", "mean speed, m/s"],
        (
            [
                *(answer.condition, one.strategy, one.minus),
                *(figure(one.gates, "+.2f"), figure(one.full, "+.0%")),
                figure(one.speed_m_s, "+.3f"),
            ]
            for answer in answers
            for one in answer.controls
            if one.strategy != one.minus
        ),
    )


def _paces(ablation: Ablation) -> str:
    return table(
        ["strategy", "mean commanded vx, m/s", "constant factor"],
        ([one.strategy, f"{one.pace_m_s:.3f}", f"{one.factor:.2f}"] for one in ablation.controls),
    )


def _both(measures: Measures, name: str) -> tuple[str, str]:
    return (
        figure(measures["gates_passed"][name], "+.2f"),
        figure(measures["is_full"][name], "+.0%"),
    )
