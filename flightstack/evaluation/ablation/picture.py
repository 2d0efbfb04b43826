"""Draw what makes the effect of mi-mode: the whole, its parts, and its slow-down alone."""

from collections.abc import Iterator
from typing import Any

from flightstack.evaluation.ablation.answer import Ablation, ConditionAnswer
from flightstack.evaluation.ablation.design import FACTORS
from flightstack.evaluation.pictures.dots import LINE_IN, draw_dot, lay_lines
from flightstack.evaluation.pictures.style import COLOURS, INK, new_figure
from flightstack.evaluation.results.statistics import CONFIDENCE, MeanEstimate

PANEL_IN = 4.4
LABELS_IN = 2.6
HEAD_IN = 1.2
WHOLE, PART, PACE = COLOURS[6], COLOURS[0], COLOURS[1]


def draw_ablation(ablation: Ablation) -> Any:
    """Return the picture: a panel per condition, a line per part."""
    answers = ablation.answers
    if not answers:
        figure = new_figure(LABELS_IN + PANEL_IN, HEAD_IN)
        figure.suptitle("No condition is complete yet", color=INK)
        return figure
    lines = max(len(list(effects(answer))) for answer in answers)
    figure = new_figure(LABELS_IN + PANEL_IN * len(answers), HEAD_IN + LINE_IN * lines)
    plots = figure.subplots(1, len(answers), squeeze=False, sharey=True)[0]
    for plot, answer in zip(plots, answers, strict=True):
        found = list(effects(answer))
        lay_lines(plot, [text for text, _, _ in found], "more gates passed than de-mean")
        plot.set_title(answer.condition, color=INK, fontsize=11, loc="left")
        for line, (_, estimate, colour) in enumerate(found):
            draw_dot(plot, estimate, line, colour=colour)
    figure.suptitle(
        f"What makes the effect of mi-mode, {CONFIDENCE:.0%} intervals"
        " (hollow: not told from zero)",
        color=INK,
        fontsize=11,
    )
    return figure


def effects(answer: ConditionAnswer) -> Iterator[tuple[str, MeanEstimate, str]]:
    """Yield what is drawn, from the top: its text, the gates it brings, its colour."""
    yield "mi-mode - de-mean", answer.whole.gates, WHOLE
    for factor in FACTORS:
        yield f"of that: {factor}", answer.shares["gates_passed"][factor], PART
    yield "constant slow-down alone", answer.pace_alone.gates, PACE
    left = next(one for one in answer.controls if one.strategy == answer.whole.strategy)
    yield "mi-mode - constant slow-down", left.gates, PACE
