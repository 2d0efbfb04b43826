"""Summarise one log, of whatever size."""

from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.columns.segments import is_large, read_parts
from flightstack.logs.commands.opening import flights_in, open_flight
from flightstack.logs.facts.merging import merge_parts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.progress import progress


def _flight_facts(flight: Flight) -> Facts:
    return summarise(flight, run_checks(flight))


def summary_of(path: Path, system: int | None) -> Facts:
    """Return the facts of one log; of a large one part by part."""
    if not is_large(path):
        return _flight_facts(open_flight(path, system))
    with progress(path.name, path.stat().st_size) as done:
        flights = flights_in(read_parts(path, report=done), system)
        return merge_parts((_flight_facts(flight), start) for flight, start in flights)
