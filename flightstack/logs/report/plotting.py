"""Pieces of plotly figures, as the plain values that plotly.js reads.

The figures are built as JSON rather than with plotly's Python classes: the page needs only
plotly.min.js, and building them takes milliseconds.
"""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

Json = dict[str, Any]
Floats = NDArray[np.float64]

MAX_POINTS = 6000  # of one line; more only slow the page down
INK, MUTED, GRID = "#1c2733", "#6b7785", "#e6eaee"
SETPOINT, RESPONSE = "#9aa5b1", "#1f6feb"
PART_COLOURS = {"aleatoric": "#e69f00", "epistemic": "#d1495b", "perceptual": "#2a9d8f"}
UNCERTAINTY_SCALE = [[0.0, "#2f7fc1"], [0.45, "#f2c14e"], [1.0, "#c1272d"]]
MODE_COLOURS = {
    "OFFBOARD": "#1f6feb",
    "GUIDED": "#1f6feb",
    "AUTO.TAKEOFF": "#2a9d8f",
    "AUTO.LOITER": "#9aa5b1",
    "AUTO.LAND": "#e69f00",
    "LAND": "#e69f00",
    "AUTO.RTL": "#d1495b",
    "RTL": "#d1495b",
    "AUTO.MISSION": "#8e6bbf",
    "POSCTL": "#5c9ead",
    "ALTCTL": "#5c9ead",
}
OTHER_MODES = ("#b58db6", "#7d8ca3", "#c2a878", "#80a1c1")


@dataclass(frozen=True, slots=True, kw_only=True)
class PlotRow:
    """One plot of the figure over time: what stands beside it, and its traces."""

    title: str
    traces: list[Json]


def mode_colour(mode: str) -> str:
    """Return the colour of a flight mode, the same on every page."""
    return MODE_COLOURS.get(mode) or OTHER_MODES[sum(mode.encode()) % len(OTHER_MODES)]


def packed(values: NDArray[Any] | Sequence[float]) -> Json:
    """Return numbers as plotly.js reads them from base64: a third of their size as text."""
    array = np.ascontiguousarray(values, dtype="<f4")
    return {"dtype": "f4", "bdata": base64.b64encode(array.tobytes()).decode()}


def thinned(x: Floats, y: Floats, max_points: int = MAX_POINTS) -> tuple[Floats, Floats]:
    """Return at most so many points, with every peak: the extremes of each stretch are kept."""
    if len(x) <= max_points:
        return x, y
    stretches = max_points // 2
    edges = np.linspace(0, len(x), stretches + 1).astype(np.intp)
    keep = np.empty(2 * stretches, dtype=np.intp)
    filled = np.where(np.isfinite(y), y, 0.0)
    for index, (first, last) in enumerate(pairwise(edges.tolist())):
        part = filled[first:last]
        ends = sorted((first + int(part.argmin()), first + int(part.argmax())))
        keep[2 * index : 2 * index + 2] = ends
    keep = np.unique(keep)
    return x[keep], y[keep]


def line(x: Floats, y: Floats, name: str, colour: str, **more: Any) -> Json:
    """Return a line over time; options go to the trace, `shape`, `width` and `dash` to its line."""
    style = {key: more.pop(key) for key in ("shape", "width", "dash") if key in more}
    x, y = thinned(x, y)
    trace: Json = {
        "type": "scatter",
        "mode": "lines",
        "x": packed(x),
        "y": packed(y),
        "name": name,
        "line": {"color": colour, "width": 1.6, **style},
        "connectgaps": False,
    }
    return {**trace, **more}


def axis(**more: Any) -> Json:
    """Return an axis in the page's style."""
    return {
        "gridcolor": GRID,
        "zerolinecolor": "#cfd6dd",
        "linecolor": "#cfd6dd",
        "tickfont": {"size": 11, "color": MUTED},
        "title": {"text": more.pop("title", ""), "font": {"size": 12, "color": INK}},
        **more,
    }


def layout(height: int, **more: Any) -> Json:
    """Return a layout in the page's style."""
    return {
        "height": height,
        "margin": {"l": 64, "r": 44, "t": 30, "b": 44},
        "modebar": {"orientation": "v", "bgcolor": "rgba(0,0,0,0)", "color": "#9aa5b1"},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "#ffffff",
        "font": {"family": "system-ui, -apple-system, Segoe UI, sans-serif", "color": INK},
        "hoverlabel": {"font": {"size": 12}},
        "legend": {"orientation": "h", "y": 1.0, "yanchor": "bottom", "font": {"size": 11}},
        **more,
    }
