"""Draw a ladder: the gates passed on each rung, a mark per row, with intervals."""

from typing import Any

from flightstack.evaluation.pictures.dots import lay_lines
from flightstack.evaluation.pictures.style import INK, new_figure, series_styles
from flightstack.evaluation.results.summary import ExperimentSummary

WIDTH_IN = 8.0
HEAD_IN = 1.5
RUNG_IN, ROW_IN = 0.16, 0.16  # of height, for a rung and for each row on it
SPREAD = 0.7  # of a line, that its rows share


def draw_ladder(summary: ExperimentSummary) -> Any:
    """Return the picture."""
    rows, rungs = summary.rows, summary.conditions
    row_styles = series_styles(rows)
    figure = new_figure(WIDTH_IN, HEAD_IN + (RUNG_IN + ROW_IN * len(rows)) * len(rungs))
    plot = figure.subplots()
    gates_total = max(cell.gates_total for cell in summary.cells)
    lay_lines(plot, rungs, f"gates passed, of {gates_total}")
    plot.set_xlim(-0.03 * gates_total, 1.03 * gates_total)
    named = set()
    for cell in summary.cells:
        look, gates = row_styles[cell.row], cell.gates
        place = (rows.index(cell.row) + 0.5) / len(rows) - 0.5
        at = rungs.index(cell.condition) + SPREAD * place
        if gates.low is not None and gates.high is not None:
            plot.plot([gates.low, gates.high], [at, at], color=look.colour, linewidth=1.6)
        style = {"color": look.colour, "marker": look.marker, "linestyle": "none"}
        name = None if cell.row in named else cell.row
        plot.plot([gates.mean], [at], label=name, markersize=6, **style)
        named.add(cell.row)
    plot.set_title(f"{summary.confidence:.0%} intervals over tracks", color=INK, fontsize=10)
    figure.legend(loc="outside lower center", ncols=min(3, len(rows)), frameon=False)
    return figure
