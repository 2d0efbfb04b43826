"""Draw how many trials are left at each gate: a curve per row, a panel per condition."""

import math
from typing import Any

import numpy as np

from flightstack.evaluation.pictures.style import INK, SeriesStyle, new_figure, plain, series_styles
from flightstack.evaluation.results.summary import Cell, ExperimentSummary

PANEL_IN = (4.6, 3.4)
MAX_PANELS_ACROSS = 3
LEGEND_LINE_IN = 0.22


def draw_survival(summary: ExperimentSummary) -> Any:
    """Return the picture."""
    conditions = summary.conditions
    across = min(MAX_PANELS_ACROSS, len(conditions))
    down = math.ceil(len(conditions) / across)
    legend_in = LEGEND_LINE_IN * (1 + math.ceil(len(summary.rows) / across))
    figure = new_figure(PANEL_IN[0] * across, PANEL_IN[1] * down + legend_in)
    plots = list(figure.subplots(down, across, squeeze=False, sharey=True).flat)
    row_styles = series_styles(summary.rows)
    for plot, condition in zip(plots, conditions, strict=False):
        for cell in summary.cells:
            if cell.condition == condition:
                _draw_curve(plot, cell, row_styles[cell.row])
        _label(plot, condition, max(cell.gates_total for cell in summary.cells))
    for plot in plots[len(conditions) :]:
        plot.set_axis_off()
    handles = {text: handle for plot in figure.axes for handle, text in _legend(plot)}
    figure.legend(
        handles.values(), handles, loc="outside lower center", ncols=across, frameon=False
    )
    return figure


def _legend(plot: Any) -> list[tuple[Any, str]]:
    return list(zip(*plot.get_legend_handles_labels(), strict=True))


def _draw_curve(plot: Any, cell: Cell, look: SeriesStyle) -> None:
    """Draw a step at every gate, from all trials before the first."""
    gates = np.arange(cell.gates_total + 1)
    curve = cell.survival
    share, low, high = (np.array([1.0, *ends]) for ends in (curve.share, curve.low, curve.high))
    plot.step(gates, share, where="pre", color=look.colour, linestyle=look.line, label=cell.row)
    plot.fill_between(gates, low, high, step="pre", color=look.colour, alpha=0.12, linewidth=0)


def _label(plot: Any, condition: str, gates: int) -> None:
    plain(plot)
    plot.set_title(condition, color=INK, fontsize=11, loc="left")
    plot.set(xlim=(0, gates), ylim=(-0.02, 1.02))
    plot.set_xlabel("gates, at least so many passed")
    if plot.get_subplotspec().is_first_col():
        plot.set_ylabel("share of trials")
    plot.yaxis.set_major_formatter(lambda share, _: f"{share:.0%}")
