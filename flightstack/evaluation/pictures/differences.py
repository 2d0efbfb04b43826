"""Draw the differences between rows, paired by track, with intervals: a forest."""

from typing import Any

from flightstack.evaluation.pictures.dots import LINE_IN, draw_dot, lay_lines
from flightstack.evaluation.pictures.style import COLOURS, INK, new_figure
from flightstack.evaluation.results.statistics import MeanEstimate
from flightstack.evaluation.results.summary import Difference, ExperimentSummary

WIDTH_IN = 11.0
HEAD_IN = 1.1
PERCENT = 100.0


def draw_differences(summary: ExperimentSummary) -> Any:
    """Return the picture: gates, whole courses and speed side by side, a line per pair."""
    shown = summary.differences
    figure = new_figure(WIDTH_IN, HEAD_IN + LINE_IN * len(shown))
    gates, full, speed = figure.subplots(1, 3, sharey=True, width_ratios=(2, 1.4, 1.4))
    many = len(summary.conditions) > 1
    texts = [f"{one.row} - {one.minus}" + f"  ({one.condition})" * many for one in shown]
    for plot, xlabel in (
        (gates, "gates passed"),
        (full, "whole courses, % points"),
        (speed, "mean speed, m/s"),
    ):
        lay_lines(plot, texts, xlabel)
    for line, one in enumerate(shown):
        colour = COLOURS[summary.conditions.index(one.condition) % len(COLOURS)]
        _draw_line(
            ((gates, one.gates), (full, _percent(one)), (speed, one.speed_m_s)), line, colour
        )
    figure.suptitle(
        f"Differences on the same tracks, {summary.confidence:.0%} intervals"
        " (hollow: not told from zero)",
        color=INK,
        fontsize=11,
    )
    return figure


def _draw_line(parts: tuple[tuple[Any, MeanEstimate], ...], line: int, colour: str) -> None:
    for plot, estimate in parts:
        draw_dot(plot, estimate, line, colour=colour)


def _percent(one: Difference) -> MeanEstimate:
    full = one.full
    return MeanEstimate(
        mean=full.mean * PERCENT,
        low=None if full.low is None else full.low * PERCENT,
        high=None if full.high is None else full.high * PERCENT,
        tracks=full.tracks,
        method=full.method,
    )
