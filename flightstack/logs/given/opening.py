"""Open what a command was given: a log, its flight, its checks."""

from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from flightstack.logs.checks import load_checks
from flightstack.logs.columns.reading import read
from flightstack.logs.columns.segments import is_large, read_parts
from flightstack.logs.errors import LogFileError
from flightstack.logs.facts.whole_log import flights_in
from flightstack.logs.flight.flight import Flight
from flightstack.logs.progress import progress

LOG_ENDINGS = (".tlog", ".mavlink", ".rlog", ".raw", ".ulg", ".bin")


def open_flight(log: str | Path, system: int | None) -> Flight:
    """Return the flight of a log that a command was given."""
    return Flight(read(log), system=system)


def flights_of(log: str | Path, system: int | None) -> Iterator[Flight]:
    """Yield the flight of a log; those of its parts where it is large."""
    if not is_large(log):
        yield open_flight(log, system)
        return
    path = Path(log)
    with progress(path.name, path.stat().st_size) as done:
        for flight, _ in flights_in(read_parts(path, report=done), system):
            yield flight


def use_checks(arguments: Namespace) -> None:
    """Register the user's own checks, if a file with them was given."""
    if arguments.checks is not None:
        load_checks(arguments.checks)


def logs_in(path: Path) -> list[Path]:
    """Return the path itself, or all logs of a folder and its folders; LogFileError for none."""
    if not path.is_dir():
        return [path]
    logs = sorted(each for each in path.rglob("*") if each.suffix.lower() in LOG_ENDINGS)
    if not logs:
        raise LogFileError(f"{path} holds no logs: no file in it ends in {', '.join(LOG_ENDINGS)}")
    return logs
