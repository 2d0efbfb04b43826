"""Draw everything over one time axis: modes, events, velocities, uncertainty, latency."""

from collections.abc import Callable

import numpy as np

from flightstack.logs.columns.time_axis import placed_us
from flightstack.logs.flight.decisions import ALL_MEMBERS, LINEAR, UNITS, VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.setpoints import boot_offset_us, stamp_latency_ms
from flightstack.logs.report.plotting import (
    INK,
    PART_COLOURS,
    RESPONSE,
    SETPOINT,
    Json,
    PlotRow,
    axis,
    layout,
    line,
    mode_colour,
)
from flightstack.logs.report.vehicle_rows import seconds_of, vehicle_rows

ROW_PX = 132
GAP_PX = 22
MODES_PX = 70
MEMBER_COLOURS = ("#1f6feb", "#2a9d8f", "#8e6bbf", "#e69f00")  # by velocity


def _velocity_rows(flight: Flight) -> list[PlotRow]:
    tracking = flight.tracking
    if not len(tracking):
        return []
    x = seconds_of(flight, tracking.time_us)
    rows = []
    for index, (name, unit) in enumerate(zip(VELOCITIES, UNITS, strict=True)):
        setpoint = line(
            x, tracking.setpoint[:, index], "setpoint", SETPOINT, shape="hv", width=2,
            legendgroup="setpoint", showlegend=index == 0,
        )  # fmt: skip
        response = line(
            x, tracking.response[:, index], "response", RESPONSE,
            legendgroup="response", showlegend=index == 0,
        )  # fmt: skip
        rows.append(PlotRow(title=f"{name}, {unit}", traces=[setpoint, response]))
    return rows


def _uncertainty_row(flight: Flight) -> list[PlotRow]:
    decisions = flight.decisions
    if not len(decisions):
        return []
    x = seconds_of(flight, decisions.time_us)
    traces = []
    for name, colour in PART_COLOURS.items():
        std = getattr(decisions, f"{name}_std")[:, LINEAR]
        length = np.asarray(np.linalg.norm(std, axis=1), dtype=np.float64)
        traces.append(line(x, length, name, colour))
    return [PlotRow(title="std, m/s", traces=traces)]


def _choice_rows(flight: Flight) -> list[PlotRow]:
    decisions = flight.decisions
    if not len(decisions):
        return []
    x = seconds_of(flight, decisions.time_us)
    chosen, modes = [], []
    for index, (name, colour) in enumerate(zip(VELOCITIES, MEMBER_COLOURS, strict=True)):
        style = {"shape": "hv", "legendgroup": name, "width": 1.3}
        member = decisions.member[:, index].astype(np.float64)
        if not (member == ALL_MEMBERS).all():
            shown = {"showlegend": True, **style}
            chosen.append(line(x, member, name, colour, **shown))
        count = decisions.modes[:, index].astype(np.float64)
        shift = 0.12 * (index - 1.5)  # so that equal counts stand beside each other
        dots = line(x, count + shift, name, colour, showlegend=not chosen, legendgroup=name)
        modes.append({**dots, "mode": "markers", "marker": {"size": 3, "color": colour}})
    rows = [PlotRow(title="member", traces=chosen)] if chosen else []
    return [*rows, PlotRow(title="modes", traces=modes)]


def _latency_row(flight: Flight) -> list[PlotRow]:
    answers = flight.answers
    if len(answers.latency_ms):
        x = seconds_of(flight, answers.time_us)
        trace = line(x, answers.latency_ms, "frame to setpoint", "#8e6bbf")
        return [PlotRow(title="latency, ms", traces=[trace])]
    if flight.vehicle is None or not len(flight.setpoints) or not flight.log.is_telemetry:
        return []  # a vehicle's own log stamps them itself
    offset_us = boot_offset_us(flight.log, flight.vehicle)
    if offset_us is None:
        return []
    late = stamp_latency_ms(flight.setpoints, offset_us)
    if not np.isfinite(late).any():
        return []
    trace = line(seconds_of(flight, flight.setpoints.time_us), late, "stamp to setpoint", "#8e6bbf")
    return [PlotRow(title="latency, ms", traces=[trace])]


def _motion_rows(flight: Flight) -> list[PlotRow]:
    motion = flight.motion
    if not len(motion):
        return []
    x = seconds_of(flight, motion.time_us)
    height = line(x, -motion.position_ned[:, 2], "height", "#1c7c54")
    speed = line(x, motion.horizontal_speed_m_s, "horizontal speed", "#33658a")
    climb = line(x, -motion.velocity_ned[:, 2], "climb", "#c08497")
    rows = [
        PlotRow(title="height, m", traces=[height]),
        PlotRow(title="m/s", traces=[speed, climb]),
    ]
    return rows[:1] if len(flight.tracking) else rows


def _attitude_row(flight: Flight) -> list[PlotRow]:
    table = flight.of_vehicle("ATTITUDE")
    if not len(table):
        return []
    x = seconds_of(flight, placed_us(table))
    colours = {"roll": "#1f6feb", "pitch": "#e69f00"}
    traces = [
        line(x, np.degrees(table[name].astype(np.float64)), name, colour)
        for name, colour in colours.items()
    ]
    return [PlotRow(title="tilt, deg", traces=traces)]


def _battery_row(flight: Flight) -> list[PlotRow]:
    battery = flight.battery
    rows = []
    if len(battery.volts) > 1:
        trace = line(seconds_of(flight, battery.voltage_at_us), battery.volts, "battery", "#6d597a")
        rows.append(PlotRow(title="battery, V", traces=[trace]))
    elif len(battery.percent) > 1:
        x = seconds_of(flight, battery.charge_at_us)
        trace = line(x, battery.percent.astype(np.float64), "battery", "#6d597a")
        rows.append(PlotRow(title="battery, %", traces=[trace]))
    return rows


ROWS: tuple[Callable[[Flight], list[PlotRow]], ...] = (
    _velocity_rows,
    _uncertainty_row,
    _choice_rows,
    _latency_row,
    _motion_rows,
    _attitude_row,
    _battery_row,
)


def _event_traces(flight: Flight) -> list[Json]:
    """Return the marks of the first row: texts and what the referee said, to hover over."""
    kinds = {
        "critical": ("x", "#c1272d", range(4)),
        "warning": ("triangle-up", "#e69f00", range(4, 5)),
        "info": ("circle", "#6b7785", range(5, 8)),
    }
    traces = []
    for name, (symbol, colour, severities) in kinds.items():
        texts = [text for text in flight.texts if text.severity in severities]
        if texts:
            traces.append(
                {
                    "type": "scatter",
                    "mode": "markers",
                    "x": [round(flight.seconds(text.time_us), 3) for text in texts],
                    "y": [0.5] * len(texts),
                    "name": name,
                    "showlegend": False,
                    "marker": {"symbol": symbol, "size": 9, "color": colour},
                    "hovertext": [f"{text.source} {text.text}" for text in texts],
                    "hoverinfo": "text+x",
                }
            )
    return traces or [{"type": "scatter", "x": [0], "y": [0.5], "opacity": 0, "showlegend": False}]


def _mode_shapes(flight: Flight) -> tuple[list[Json], list[Json]]:
    """Return coloured bands behind all rows, and the modes' names in the first."""
    shapes, names = [], []
    total_s = max(flight.seconds(flight.end_us), 1e-3)
    for span in flight.modes:
        x0, x1 = flight.seconds(span.start_us), flight.seconds(span.end_us)
        band = {"type": "rect", "xref": "x", "x0": x0, "x1": x1, "line": {"width": 0}}
        colour = mode_colour(span.label)
        band["layer"] = "below"
        shapes.append(
            {**band, "yref": "paper", "y0": 0, "y1": 1, "fillcolor": colour, "opacity": 0.07}
        )
        shapes.append({**band, "yref": "y", "y0": 0, "y1": 1, "fillcolor": colour, "opacity": 0.35})
        if (x1 - x0) / total_s > 0.06:
            names.append(
                {
                    "x": (x0 + x1) / 2, "xref": "x", "y": 0.9, "yref": "y", "yanchor": "top",
                    "text": span.label, "showarrow": False, "font": {"size": 11, "color": INK},
                }
            )  # fmt: skip
    names += [
        {
            "x": flight.seconds(time_us), "xref": "x", "y": 0.05, "yref": "y", "yanchor": "bottom",
            "text": "started again", "showarrow": False, "font": {"size": 11, "color": INK},
        }
        for time_us in flight.restarts
    ]  # fmt: skip
    return shapes, names


def _event_lines(flight: Flight) -> list[Json]:
    colours = {"passed": "#2a9d8f", "missed": "#c1272d", "collision": "#c1272d"}
    marked = [(e.time_us, colours[e.kind]) for e in flight.course_events if e.kind in colours]
    marked += [(time_us, INK) for time_us in flight.restarts]
    return [
        {
            "type": "line", "xref": "x", "yref": "paper", "y0": 0, "y1": 1,
            "x0": flight.seconds(time_us), "x1": flight.seconds(time_us),
            "line": {"color": colour, "width": 1, "dash": "dot"},
        }
        for time_us, colour in marked
    ]  # fmt: skip


def time_figure(flight: Flight) -> Json:
    """Return the figure: one row above the other, zoomed together."""
    rows = [row for make in ROWS for row in make(flight)]
    rows += vehicle_rows(flight)
    height = MODES_PX + len(rows) * (ROW_PX + GAP_PX)
    total = height + 72
    top = 1.0
    shapes, names = _mode_shapes(flight)
    axes: Json = {"yaxis": axis(title="modes", domain=[1 - MODES_PX / height, 1], range=[0, 1])}
    axes["yaxis"].update(showticklabels=False, showgrid=False, zeroline=False, fixedrange=True)
    top -= MODES_PX / height
    traces = [{**trace, "yaxis": "y"} for trace in _event_traces(flight)]
    for index, row in enumerate(rows, start=2):
        low = top - (ROW_PX + GAP_PX) / height
        axes[f"yaxis{index}"] = axis(title=row.title, domain=[max(low, 0), top - GAP_PX / height])
        traces += [{**trace, "yaxis": f"y{index}"} for trace in row.traces]
        top = low
    last = f"y{len(rows) + 1}" if rows else "y"
    axes["xaxis"] = axis(title="seconds since the start of the log", anchor=last)
    whole = [0, flight.seconds(flight.end_us)]
    axes["xaxis"].update(range=whole, showspikes=True, spikemode="across", spikethickness=1)
    return {
        "data": [{**trace, "xaxis": "x"} for trace in traces],
        "layout": layout(
            total,
            shapes=shapes + _event_lines(flight),
            annotations=names,
            hovermode="x",
            hoverdistance=30,
            **axes,
        ),
    }
