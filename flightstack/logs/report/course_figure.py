"""Draw the course: from above and from the side, gates, and the path by its uncertainty."""

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.flight.course import CourseEvent, CourseGate, gate_outline
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.motion import interpolated
from flightstack.logs.report.plotting import (
    INK,
    MUTED,
    RESPONSE,
    UNCERTAINTY_SCALE,
    Floats,
    Json,
    axis,
    layout,
    packed,
)

MAX_MARKERS = 3000
SCALE_PARTS = 5  # the bar is about this part of the path's extent
METRES_A_KM = 1000
EVENT_MARKS = {
    "passed": ("circle", "#2a9d8f"),
    "missed": ("x", "#c1272d"),
    "collision": ("star", "#c1272d"),
    "finished": ("diamond", "#2a9d8f"),
}


def _positions(flight: Flight, times: NDArray[np.int64]) -> Floats:
    return interpolated(times, flight.motion.time_us, flight.motion.position_ned)


def _both_views(points: Floats, trace: Json, shown: str) -> list[Json]:
    """Return a trace in the view from above and the view from the side."""
    north, east, down = points.T
    above = {**trace, "x": packed(east), "y": packed(north), "name": shown, "legendgroup": shown}
    side = {**above, "y": packed(-down), "showlegend": False, "xaxis": "x2", "yaxis": "y2"}
    return [above, side]


def _gates(gates: list[CourseGate]) -> list[Json]:
    if not gates:
        return []
    gap = np.full((1, 3), np.nan)
    outline = np.vstack([part for gate in gates for part in (gate_outline(gate), gap)])
    style = {
        "type": "scatter",
        "mode": "lines",
        "line": {"color": INK, "width": 3.5},
        "hoverinfo": "skip",
        "connectgaps": False,
    }
    centres = np.array([gate.centre_ned for gate in gates])
    names = {
        "type": "scatter",
        "mode": "text",
        "text": [f"{gate.index + 1}" for gate in gates],
        "textposition": "top right",
        "textfont": {"size": 12, "color": MUTED},
        "hovertext": [f"gate {gate.index + 1}" for gate in gates],
        "hoverinfo": "text",
        "showlegend": False,
    }
    return _both_views(outline, style, "gates") + _both_views(centres, names, "gate numbers")


def _path(flight: Flight) -> list[Json]:
    motion = flight.motion
    step = max(1, len(motion) // MAX_MARKERS)
    grey = {
        "type": "scatter",
        "mode": "lines",
        "line": {"color": "#b8c1cb" if len(flight.decisions) else RESPONSE, "width": 1.5},
        "hoverinfo": "skip",
    }
    return _both_views(motion.position_ned[::step], grey, "path")


def _uncertain_path(flight: Flight) -> list[Json]:
    decisions = flight.decisions
    if not len(decisions):
        return []
    step = max(1, len(decisions) // MAX_MARKERS)
    rows = slice(None, None, step)
    total = decisions.total_std_m_s[rows]
    seconds = (decisions.time_us[rows] - flight.start_us) * 1e-6
    top = float(np.percentile(total, 98)) if len(total) else 1.0
    marks = {
        "type": "scatter",
        "mode": "markers",
        "marker": {
            "size": 6,
            "color": packed(total),
            "colorscale": UNCERTAINTY_SCALE,
            "cmin": float(total.min()),
            "cmax": max(top, float(total.min()) + 1e-6),
            "colorbar": {
                "title": {"text": "total std<br>m/s", "font": {"size": 11}},
                "thickness": 12,
                "len": 0.42,
                "y": 0.78,
                "yanchor": "top",
            },
        },
        "customdata": np.round(np.stack([seconds, total], axis=1), 3).tolist(),
        "hovertemplate": "%{customdata[0]:.2f} s, std %{customdata[1]:.3f} m/s<extra></extra>",
    }
    above, side = _both_views(_positions(flight, decisions.time_us[rows]), marks, "uncertainty")
    side["marker"] = {key: value for key, value in marks["marker"].items() if key != "colorbar"}
    return [above, side]


def _events(flight: Flight, events: list[CourseEvent]) -> list[Json]:
    traces = []
    for kind, (symbol, colour) in EVENT_MARKS.items():
        rows = [event for event in events if event.kind == kind]
        if not rows:
            continue
        times = np.array([event.time_us for event in rows], dtype=np.int64)
        marks = {
            "type": "scatter",
            "mode": "markers",
            "marker": {"symbol": symbol, "size": 12, "color": colour, "line": {"width": 1}},
            "hovertext": [f"{flight.seconds(e.time_us):.2f} s: {e.text}" for e in rows],
            "hoverinfo": "text",
        }
        traces += _both_views(_positions(flight, times), marks, kind)
    return traces


def has_path(flight: Flight) -> bool:
    """Return whether the log holds positions to draw."""
    return len(flight.motion) > 1


def has_course(flight: Flight) -> bool:
    """Return whether the log tells of gates to fly through."""
    return bool(flight.gates or flight.course_events or flight.gates_passed)


def _scale(flight: Flight) -> tuple[list[Json], list[Json]]:
    """Return a bar of a round length at the lower left of the view from above, and its label."""
    north, east, _ = flight.motion.position_ned.T
    extent = max(float(np.ptp(north)), float(np.ptp(east)), 1.0)
    wanted = extent / SCALE_PARTS
    power = 10.0 ** np.floor(np.log10(wanted))
    length = float(power * max(step for step in (1, 2, 5) if step * power <= wanted))
    x0, y0 = float(east.min()), float(north.min()) - extent / 12
    bar: Json = {"type": "line", "xref": "x", "yref": "y", "x0": x0, "x1": x0 + length}
    bar |= {"y0": y0, "y1": y0, "line": {"color": INK, "width": 3}}
    text = f"{length:g} m" if length < METRES_A_KM else f"{length / METRES_A_KM:g} km"
    label: Json = {"x": x0, "y": y0, "xref": "x", "yref": "y", "xanchor": "left", "text": text}
    label |= {"yanchor": "bottom", "showarrow": False, "font": {"size": 12, "color": INK}}
    return [bar], [label]


def course_figure(flight: Flight) -> Json:
    """Return the figure of the path, and the course where there is one."""
    traces = _path(flight) + _gates(flight.gates) + _uncertain_path(flight)
    traces += _events(flight, flight.course_events)
    shapes, labels = _scale(flight)
    return {
        "data": traces,
        "layout": layout(
            860,
            xaxis=axis(anchor="y", domain=[0, 1], matches="x2", showticklabels=False),
            yaxis=axis(title="north, m", domain=[0.36, 1], scaleanchor="x", scaleratio=1),
            xaxis2=axis(title="east, m", anchor="y2", domain=[0, 1]),
            yaxis2=axis(title="height, m", domain=[0, 0.3], scaleanchor="x2", scaleratio=1),
            hovermode="closest",
            shapes=shapes,
            annotations=labels,
            dragmode="zoom",
        ),
    }
