"""Open what a command was given: a log, its flight, its checks."""

from argparse import Namespace
from pathlib import Path

from flightstack.logs.checks import load_checks
from flightstack.logs.columns.reading import read
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight

LOG_ENDINGS = (".tlog", ".mavlink", ".rlog", ".raw", ".ulg", ".bin")


def open_flight(log: str | Path, system: int | None) -> Flight:
    """Return the flight of a log that a command was given."""
    return Flight(read(log), system=system)


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
