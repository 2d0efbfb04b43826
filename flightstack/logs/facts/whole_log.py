"""Summarise one log, of whatever size: a large one part by part."""

from collections.abc import Iterator
from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.columns.reading import read
from flightstack.logs.columns.segments import LogPart, is_large, read_parts
from flightstack.logs.facts.merging import merge_parts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.progress import progress


def flights_in(parts: Iterator[LogPart], system: int | None) -> Iterator[tuple[Flight, int]]:
    """Yield the flights in the parts of one log, all of one vehicle, and where each starts."""
    chosen = system
    for part in parts:
        flight = Flight(part.log, chosen)
        if chosen is None and flight.vehicle is not None:
            chosen = flight.vehicle.system
        yield flight, part.start


def _flight_facts(flight: Flight) -> Facts:
    return summarise(flight, run_checks(flight))


def summary_of(path: Path, system: int | None) -> Facts:
    """Return the facts of one log; of a large one part by part."""
    if not is_large(path):
        return _flight_facts(Flight(read(path), system=system))
    with progress(path.name, path.stat().st_size) as done:
        flights = flights_in(read_parts(path, report=done), system)
        return merge_parts((_flight_facts(flight), start) for flight, start in flights)
