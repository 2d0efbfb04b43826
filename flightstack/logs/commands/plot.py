"""Command: fields over time as PNG or SVG, on a background of flight modes."""

import json
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from flightstack.libraries import load_pyplot
from flightstack.logs.columns.expression import series
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight
from flightstack.logs.given.arguments import writing
from flightstack.logs.given.opening import open_flight
from flightstack.logs.report.plotting import mode_colour

ENDINGS = (".png", ".svg", ".pdf")
MIN_NAMED_SHARE = 0.06  # of the width: narrower modes are coloured only


def _background(axes: Any, flight: Flight, shown: tuple[float, float], *, named: bool) -> None:
    for span in flight.modes:
        first = max(flight.seconds(span.start_us), shown[0])
        last = min(flight.seconds(span.end_us), shown[1])
        if first >= last:
            continue
        axes.axvspan(first, last, color=mode_colour(span.label), alpha=0.15, linewidth=0)
        if named and last - first > MIN_NAMED_SHARE * (shown[1] - shown[0]):
            top = axes.get_xaxis_transform()
            axes.text((first + last) / 2, 1.02, span.label, transform=top, ha="center", fontsize=7)


def _groups(flight: Flight, fields: list[str]) -> dict[str, list[tuple[str, Any, Any]]]:
    """Return the series by unit: those of one unit share one plot."""
    groups: dict[str, list[tuple[str, Any, Any]]] = {}
    for field in fields:
        times, values, unit = series(field, flight.log, flight.autopilot)
        seconds = (times - flight.start_us) * 1e-6
        groups.setdefault(unit, []).append((field, seconds, values))
    return groups


def draw(flight: Flight, arguments: Namespace, output: Path) -> None:
    """Draw the fields to a file."""
    pyplot = load_pyplot("logs")
    groups = _groups(flight, arguments.fields)
    shown = (
        0.0 if arguments.start is None else arguments.start,
        flight.seconds(flight.end_us) if arguments.end is None else arguments.end,
    )
    figure, axes = pyplot.subplots(
        len(groups), 1, sharex=True, squeeze=False, figsize=(10, 1.2 + 2.6 * len(groups))
    )
    for index, (each, (unit, lines)) in enumerate(zip(axes[:, 0], groups.items(), strict=True)):
        for name, seconds, values in lines:
            few = len(values) < 30
            each.plot(seconds, values, label=name, linewidth=1, marker="." if few else "")
        _background(each, flight, shown, named=index == 0)
        each.set_ylabel(unit)
        each.legend(loc="upper right", fontsize=8)
        each.grid(alpha=0.3)
    axes[-1, 0].set_xlim(*shown)
    axes[-1, 0].set_xlabel("seconds since the start of the log")
    figure.suptitle(Path(flight.log.name).name, fontsize=10)
    figure.tight_layout()
    try:
        with writing(output):
            figure.savefig(output, dpi=120)
    finally:
        pyplot.close(figure)


def run(arguments: Namespace) -> int:
    """Draw the fields and say where."""
    output: Path = arguments.output or Path(arguments.log).with_suffix(".png")
    if output.suffix.lower() not in ENDINGS:
        raise LogFileError(f"-o {output}: name a file that ends in {', '.join(ENDINGS)}")
    flight = open_flight(arguments.log, arguments.system)
    with np.errstate(all="ignore"):
        draw(flight, arguments, output)
    print(json.dumps({"plot": str(output)}) if arguments.json else f"wrote {output}")
    return 0
