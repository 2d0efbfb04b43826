"""Draw every trial from above, coloured by uncertainty: a panel per row and condition."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.pictures.style import INK, MUTED, new_figure, plain
from flightstack.libraries import load_library
from flightstack.logs.flight.course import DEFAULT_HALF_OPENING_M

PANEL_IN = 3.1
EDGE_IN = 0.9
MAX_PANELS_ACROSS = 6
GATES = {"colors": MUTED, "linewidths": 1.0, "alpha": 0.6}
COLOUR_MAP = "viridis"  # even in grey, and for the colour-blind
BRIGHTEST_PERCENTILE = 98.0  # of uncertainty: a few wild decisions must not dull all others
FAILED = "#d55e00"


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """One trial: where it flew, and whether it came to the end."""

    trace: Trace
    is_full: bool


def draw_birds_eye(ways: Mapping[tuple[str, str], Sequence[Way]]) -> Any:
    """Return the picture; ways by (row, condition)."""
    rows = list(dict.fromkeys(row for row, _ in ways))
    conditions = list(dict.fromkeys(condition for _, condition in ways))
    across = min(MAX_PANELS_ACROSS, len(conditions))
    lines = math.ceil(len(conditions) / across)  # that a row takes
    down = lines * len(rows)
    figure = new_figure(PANEL_IN * across + EDGE_IN, PANEL_IN * down + EDGE_IN)
    plots = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    scale = colour_scale([way.trace.uncertainty for own in ways.values() for way in own])
    for place, row in enumerate(rows):
        panels = plots[place * lines : (place + 1) * lines].flat
        for plot, condition in itertools.zip_longest(panels, conditions):
            if condition is None:
                plot.set_axis_off()
                continue
            _draw_panel(plot, ways.get((row, condition), ()), scale)
            plot.set_title(f"{row}, {condition}", color=INK, fontsize=9, loc="left")
            plot.label_outer()
    bar = figure.colorbar(scale, ax=plots, shrink=min(1.0, 2.0 / down), aspect=30)
    bar.set_label("standard deviation of the decision, m/s", color=INK)
    return figure


def colour_scale(uncertainty: Sequence[NDArray[np.float64]]) -> Any:
    """Return one scale for all panels, from zero to what nearly all decisions stay below."""
    known = np.concatenate([values[np.isfinite(values)] for values in uncertainty])
    brightest = float(np.percentile(known, BRIGHTEST_PERCENTILE)) if len(known) else 1.0
    norm = load_library("matplotlib.colors", "evaluation").Normalize(0.0, brightest or 1.0)
    return load_library("matplotlib.cm", "evaluation").ScalarMappable(norm, COLOUR_MAP)


def gate_bars(gates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return both ends of each gate's opening from above, (G, 2, 2) east and north in m."""
    across = DEFAULT_HALF_OPENING_M * np.stack([np.cos(gates[:, 3]), -np.sin(gates[:, 3])], axis=1)
    centre = gates[:, [1, 0]]
    return np.stack([centre - across, centre + across], axis=1)


def _draw_panel(plot: Any, ways: Sequence[Way], scale: Any) -> None:
    lines = load_library("matplotlib.collections", "evaluation").LineCollection
    for way in ways:
        bars = gate_bars(way.trace.gates)
        plot.add_collection(lines(bars, zorder=1, **GATES))
    for way in ways:
        path = way.trace.position_ned[:, [1, 0]]  # (T, 2) east, north
        steps = np.stack([path[:-1], path[1:]], axis=1)
        colours = scale.to_rgba(way.trace.uncertainty[1:])
        plot.add_collection(lines(steps, colors=colours, linewidths=1.0, alpha=0.8, zorder=2))
        if not way.is_full and len(path):
            plot.plot(*path[-1], marker="x", color=FAILED, markersize=6, zorder=3)
    full = sum(way.is_full for way in ways)
    plot.annotate(
        f"{full} of {len(ways)} whole",
        (0.02, 0.02),
        xycoords="axes fraction",
        color=MUTED,
        fontsize=8,
    )
    plain(plot)
    plot.set_aspect("equal", adjustable="box")
    plot.autoscale_view()
    plot.set_xlabel("east, m")
    plot.set_ylabel("north, m")
