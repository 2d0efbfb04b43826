"""Rows of the figure over time for the vehicle's owner: GPS, airspeed, RC, outputs, health."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.table import Table
from flightstack.logs.columns.time_axis import placed_us
from flightstack.logs.flight.flight import Flight
from flightstack.logs.report.plotting import Floats, PlotRow, line

PALETTE = (
    *("#1f6feb", "#e69f00", "#2a9d8f", "#d1495b", "#8e6bbf", "#5c9ead", "#c2a878", "#6b7785"),
    *("#33658a", "#c08497", "#1c7c54", "#b58db6", "#7d8ca3", "#80a1c1", "#6d599a", "#9aa5b1"),
)
UNUSED = 65535  # of a channel
VIBRATION = ("vibration_x", "vibration_y", "vibration_z")
RATIOS = {  # of innovations to what is allowed, 1 is the limit
    "EKF_STATUS_REPORT": (
        "velocity_variance",
        "pos_horiz_variance",
        "pos_vert_variance",
        "compass_variance",
    ),
    "ESTIMATOR_STATUS": ("vel_ratio", "pos_horiz_ratio", "pos_vert_ratio", "mag_ratio"),
}
SHORT = {
    "_variance": "",
    "_ratio": "",
    "pos_": "",
    "vibration_": "",
    "_raw": "",
    "servo": "output ",
}


def seconds_of(flight: Flight, times: NDArray[np.int64]) -> Floats:
    """Return times as seconds since the start of the log."""
    return np.multiply(times - flight.start_us, 1e-6, dtype=np.float64)


def _called(name: str) -> str:
    for part, instead in SHORT.items():
        name = name.replace(part, instead)
    return name.replace("_", " ")


def _lines(flight: Flight, table: Table, names: Sequence[str], title: str) -> list[PlotRow]:
    """Return a row with these fields, without those that are never told."""
    if len(table) < 2:
        return []
    x = seconds_of(flight, placed_us(table))
    traces = []
    for colour, name in zip(PALETTE, names, strict=False):
        values = table[name].astype(np.float64)
        if table.data.dtype[name].kind == "u":
            values[values == UNUSED] = np.nan
        if np.isfinite(values).any() and np.nanmax(np.abs(values)) > 0:
            traces.append(line(x, values, _called(name), colour))
    return [PlotRow(title=title, traces=traces)] if traces else []


def _gps(flight: Flight) -> list[PlotRow]:
    gps = flight.gps
    if len(gps) < 2:
        return []
    x = seconds_of(flight, gps.time_us)
    traces = [
        line(x, gps.satellites, "satellites", PALETTE[0], shape="hv"),
        line(x, gps.hdop, "HDOP", PALETTE[1]),
        line(x, gps.fix.astype(np.float64), "fix (3 is 3D)", PALETTE[2], shape="hv"),
    ]
    return [PlotRow(title="GPS", traces=traces)]


def _airspeed(flight: Flight) -> list[PlotRow]:
    table = flight.of_vehicle("VFR_HUD")
    if len(table) < 2 or not table["airspeed"].any():
        return []
    return _lines(flight, table, ("airspeed", "groundspeed"), "VFR, m/s")


def _channels(flight: Flight) -> list[PlotRow]:
    for message, count in (("RC_CHANNELS", 16), ("RC_CHANNELS_RAW", 8)):
        table = flight.of_vehicle(message)
        if len(table) > 1:
            names = [f"chan{number}_raw" for number in range(1, count + 1)]
            return _lines(flight, table, names, "RC, us")
    return []


def _outputs(flight: Flight) -> list[PlotRow]:
    table = flight.of_vehicle("SERVO_OUTPUT_RAW")
    table = table.take(table["port"] == 0)
    names = [f"servo{n}_raw" for n in range(1, 17)]
    moved = [
        name for name in names if len(table) and np.ptp(table[name]) > 0
    ]  # others drive nothing
    return _lines(flight, table, moved, "outputs, us")


def _estimator(flight: Flight) -> list[PlotRow]:
    for message, names in RATIOS.items():
        rows = _lines(flight, flight.of_vehicle(message), names, "EKF, 1 is too much")
        if rows:
            return rows
    return []


def vehicle_rows(flight: Flight) -> Iterator[PlotRow]:
    """Yield what the vehicle told of itself, each where it did."""
    yield from _airspeed(flight)
    yield from _gps(flight)
    yield from _channels(flight)
    yield from _outputs(flight)
    yield from _lines(flight, flight.of_vehicle("VIBRATION"), VIBRATION, "vibration, m/s/s")
    yield from _estimator(flight)
