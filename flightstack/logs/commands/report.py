"""Command: one HTML page with all of the flight."""

import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.alignment.alignment import align
from flightstack.logs.checks import run_checks
from flightstack.logs.flight.flight import Flight
from flightstack.logs.given.arguments import check_folder, writing
from flightstack.logs.given.opening import open_flight, use_checks
from flightstack.logs.report.beside_figure import BesideLog, beside_facts
from flightstack.logs.report.page import make_page


def _beside(flight: Flight, other: Path | None) -> BesideLog | None:
    """Return the vehicle's own log that --with names, aligned; None where it names none."""
    if other is None:
        return None
    own = open_flight(other, None)
    return BesideLog(flight=own, alignment=align(flight, own))


def run(arguments: Namespace) -> int:
    """Write the report and say where it is."""
    use_checks(arguments)
    check_folder(arguments.frames)
    flight = open_flight(arguments.log, arguments.system)
    beside = _beside(flight, arguments.beside)
    page = make_page(flight, run_checks(flight), arguments.frames, beside)
    output: Path = arguments.output or Path(arguments.log).with_suffix(".html")
    with writing(output):
        output.write_text(page, encoding="utf-8")
    if arguments.json:
        about = {} if beside is None else {"with": beside_facts(flight, beside)}
        print(json.dumps({"report": str(output), **about}))
        return 0
    if beside is not None:
        print(f"{beside.flight.log.name} {beside.alignment.words()}")
    print(f"wrote {output}")
    return 0
