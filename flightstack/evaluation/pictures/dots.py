"""Draw estimates as dots with their intervals, one under the other."""

from collections.abc import Sequence
from typing import Any

from flightstack.evaluation.pictures.style import GROUND, INK, MUTED, plain
from flightstack.evaluation.results.statistics import MeanEstimate

LINE_IN = 0.26


def draw_dot(
    plot: Any, estimate: MeanEstimate, at: float, *, colour: str, marker: str = "o"
) -> None:
    """Draw one; hollow where the interval holds zero, or has no width, or where there is none."""
    low, high = estimate.low, estimate.high
    is_sure = False
    if low is not None and high is not None and low < high:
        is_sure = low > 0.0 or high < 0.0
        plot.plot([low, high], [at, at], color=colour, linewidth=1.6, solid_capstyle="butt")
    plot.plot(
        [estimate.mean],
        [at],
        marker=marker,
        markersize=6,
        color=colour,
        markerfacecolor=colour if is_sure else GROUND,
        linestyle="none",
    )


def lay_lines(plot: Any, texts: Sequence[str], xlabel: str) -> None:
    """Name the lines, the first one on top, and mark zero."""
    plain(plot, grid="x")
    plot.set(ylim=(len(texts) - 0.5, -0.5), yticks=range(len(texts)), xlabel=xlabel)
    plot.set_yticklabels(texts, color=INK)
    plot.tick_params(axis="y", length=0)
    plot.axvline(0.0, color=MUTED, linewidth=1.0)
