"""Draw two logs of one flight over one axis: what was commanded and told, wanted, and done."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.alignment.alignment import Alignment
from flightstack.logs.facts.values import Facts, rounded
from flightstack.logs.flight.decisions import VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.motion import interpolated
from flightstack.logs.flight.tracking import Tracking, response_lag_s
from flightstack.logs.report.plotting import RESPONSE, SETPOINT, Floats, Json, axis, layout, line

WANTED, TOLD, DONE = "#8e6bbf", "#2a9d8f", RESPONSE
COLOURS = ("#1f6feb", "#e69f00", "#2a9d8f", "#c1272d", "#8e6bbf", "#6d597a", "#33658a", "#c08497")
ROW_PX, GAP_PX = 132, 22
MOTORS = 8
IDLE_US, RANGE_US = 1000.0, 1000.0
RATIOS = {  # of either autopilot: how far measurements are from the estimate; above 1 is refused
    "ESTIMATOR_STATUS": ("vel_ratio", "pos_horiz_ratio", "pos_vert_ratio", "mag_ratio"),
    "EKF_STATUS_REPORT": (
        "velocity_variance", "pos_horiz_variance", "pos_vert_variance", "compass_variance",
    ),
}  # fmt: skip
RATIO_NAMES = ("velocity", "position", "height", "compass")


@dataclass(frozen=True, slots=True, kw_only=True)
class BesideLog:
    """The vehicle's own log of a flight, and how its times become those of the flight's log."""

    flight: Flight
    alignment: Alignment


def _rotated(velocity: Floats, yaw: Floats) -> Floats:
    """Return velocities (n, 3) north, east, down as forward, right, down."""
    north, east, down = velocity.T
    forward = np.cos(yaw) * north + np.sin(yaw) * east
    return np.stack([forward, np.cos(yaw) * east - np.sin(yaw) * north, down], axis=1)


def _own_velocities(beside: BesideLog, name: str, *, in_body: bool) -> tuple[Floats, Floats]:
    """Return times and velocities (n, 3) of a message of the vehicle's log, in the given frame."""
    table = beside.flight.of_vehicle(name)
    velocity = np.stack([table[a] for a in ("vx", "vy", "vz")], axis=1).astype(np.float64)
    if in_body:
        attitude = beside.flight.of_vehicle("ATTITUDE")
        yaw = np.unwrap(attitude["yaw"].astype(np.float64))[:, None]
        velocity = _rotated(velocity, interpolated(table.time_us, attitude.time_us, yaw)[:, 0])
    return _log_us(beside, table.time_us), velocity


def _log_us(beside: BesideLog, times: NDArray[np.int64]) -> Floats:
    return beside.alignment.log_us(times)


def measured_lags(flight: Flight, beside: BesideLog) -> Facts:
    """Return by how much each velocity follows the companion's command, s, as each log tells it.

    `wanted`: what the vehicle's controller follows; `done`: what its estimator says; `told`: what
    came back to the companion.
    """
    told = flight.tracking
    in_body = told.frame == "body"
    facts: Facts = {"told": dict(zip(VELOCITIES[:3], flight.response_lags_s, strict=False))}
    messages = {"wanted": "POSITION_TARGET_LOCAL_NED", "done": "LOCAL_POSITION_NED"}
    for key, name in messages.items():
        at, velocity = _own_velocities(beside, name, in_body=in_body)
        there = interpolated(told.time_us, at.astype(np.int64), velocity, outside=np.nan)
        response = np.hstack([there, np.full((len(there), 1), np.nan)])
        tracking = Tracking(
            time_us=told.time_us, frame=told.frame, setpoint=told.setpoint, response=response
        )
        lags = [rounded(response_lag_s(tracking, number)) for number in range(3)]
        facts[key] = dict(zip(VELOCITIES[:3], lags, strict=True))
    return facts


def beside_facts(flight: Flight, beside: BesideLog) -> Facts:
    """Return how both logs fit, and how late each stage is, ready for JSON."""
    fit = beside.alignment
    return {
        "log": beside.flight.log.name,
        "method": fit.method,
        "words": fit.words(),
        "rate_ppm": rounded((fit.clock.rate - fit.other_clock.rate) * 1e6, 1),
        "shift_s": rounded(fit.shift_us * 1e-6, 6),
        "late_ms": rounded(fit.late_ms),
        "residual_deg": rounded(float(np.degrees(fit.residual_rad))),
        "correlation": rounded(fit.correlation),
        "overlap_s": rounded(fit.overlap_s),
        "lags_s": measured_lags(flight, beside) if len(flight.tracking) else None,
    }


def beside_words(facts: Facts) -> str:
    """Return how well both logs fit and how late each stage is, for people."""
    words = [facts["log"] + ", " + facts["words"] + "."]
    lags = facts["lags_s"] or {}
    stages = {"wanted": "the controller wants it", "done": "it flies so", "told": "it is told so"}
    for key, stage in stages.items():
        known = [
            f"{name} {lag:.2f} s" for name, lag in lags.get(key, {}).items() if lag is not None
        ]
        if known:
            words.append(f"From the command until {stage}: {', '.join(known)}.")
    return " ".join(words)


class _Rows:
    """Collects the rows of the figure, in seconds of the flight's log."""

    def __init__(self, flight: Flight, beside: BesideLog) -> None:
        self.flight = flight
        self.beside = beside
        self.rows: list[tuple[str, list[Json]]] = []

    def seconds(self, times: Floats | NDArray[np.int64]) -> Floats:
        return np.multiply(times - self.flight.start_us, 1e-6, dtype=np.float64)

    def own_seconds(self, times: NDArray[np.int64]) -> Floats:
        return self.seconds(_log_us(self.beside, times))

    def velocities(self) -> None:
        """Add each velocity: commanded, told to the companion, wanted by the vehicle, estimated."""
        told = self.flight.tracking
        in_body = told.frame == "body" and len(told) > 0
        wanted = _own_velocities(self.beside, "POSITION_TARGET_LOCAL_NED", in_body=in_body)
        done = _own_velocities(self.beside, "LOCAL_POSITION_NED", in_body=in_body)
        x = self.seconds(told.time_us)
        for number, name in enumerate(VELOCITIES[:3]):
            shown = {"showlegend": number == 0}
            traces = [
                line(self.seconds(at), values[:, number], word, colour, legendgroup=word, **shown)
                for word, colour, (at, values) in (
                    ("controller wants", WANTED, wanted), ("estimator says", DONE, done)
                )
                if len(at)
            ]  # fmt: skip
            if len(told):
                command = line(x, told.setpoint[:, number], "companion commands", SETPOINT,
                               shape="hv", width=2, legendgroup="command", **shown)  # fmt: skip
                back = line(x, told.response[:, number], "companion is told", TOLD,
                            legendgroup="told", **shown)  # fmt: skip
                traces = [command, *traces, back]
            self.rows.append((f"{name}, m/s", traces))

    def tilt(self) -> None:
        """Add roll and pitch, as the vehicle logged them and as the companion was told."""
        own, told = (each.of_vehicle("ATTITUDE") for each in (self.beside.flight, self.flight))
        for name in ("roll", "pitch"):
            traces = [
                line(x, np.degrees(table[name].astype(np.float64)), word, colour, showlegend=False)
                for word, colour, table, x in (
                    (f"{name} estimated", DONE, own, self.own_seconds(own.time_us)),
                    (f"{name} told", TOLD, told, self.seconds(told.time_us)),
                )
            ]
            self.rows.append((f"{name}, deg", traces))

    def uncertainty(self) -> None:
        """Add what the companion believed of its own commands."""
        decisions = self.flight.decisions
        if len(decisions):
            x = self.seconds(decisions.time_us)
            trace = line(x, decisions.total_std_m_s, "std of the command", SETPOINT)
            self.rows.append(("std, m/s", [trace]))

    def estimator(self) -> None:
        """Add how far measurements are from the vehicle's estimate."""
        for name, fields in RATIOS.items():
            table = self.beside.flight.of_vehicle(name)
            if not len(table):
                continue
            x = self.own_seconds(table.time_us)
            traces = [
                line(x, table[field].astype(np.float64), word, colour)
                for field, word, colour in zip(fields, RATIO_NAMES, COLOURS, strict=False)
            ]
            self.rows.append(("test ratio", traces))

    def motors(self) -> None:
        """Add the outputs to the motors."""
        table = self.beside.flight.of_vehicle("SERVO_OUTPUT_RAW")
        x = self.own_seconds(table.time_us)
        traces = []
        for number in range(MOTORS if len(table) else 0):
            pulse = table[f"servo{number + 1}_raw"].astype(np.float64)
            if np.ptp(pulse) > 0:
                percent = (pulse - IDLE_US) / RANGE_US * 100
                traces.append(line(x, percent, f"output {number + 1}", COLOURS[number]))
        if traces:
            self.rows.append(("outputs, %", traces))


def beside_figure(flight: Flight, beside: BesideLog) -> Json:
    """Return the figure: one row above the other, zoomed together."""
    made = _Rows(flight, beside)
    for add in (made.velocities, made.tilt, made.uncertainty, made.estimator, made.motors):
        add()
    rows = made.rows
    height = len(rows) * (ROW_PX + GAP_PX)
    axes: Json = {}
    traces: list[Json] = []
    for index, (title, lines) in enumerate(rows):
        name = "" if index == 0 else str(index + 1)
        top = 1 - index * (ROW_PX + GAP_PX) / height
        low = max(top - ROW_PX / height, 0.0)
        axes[f"yaxis{name}"] = axis(title=title, domain=[low, top])
        traces += [{**each, "xaxis": "x", "yaxis": f"y{name}"} for each in lines]
    last = "y" if len(rows) == 1 else f"y{len(rows)}"
    axes["xaxis"] = axis(title="seconds since the start of the log", anchor=last)
    whole = [0, flight.seconds(flight.end_us)]
    axes["xaxis"].update(range=whole, showspikes=True, spikemode="across", spikethickness=1)
    return {"data": traces, "layout": layout(height + 72, hovermode="x", hoverdistance=30, **axes)}
