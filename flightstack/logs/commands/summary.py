"""Command: what happened, on one page; one line a log for folders."""

import json
import sys
from argparse import Namespace
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.columns.segments import Progress, is_large, read_parts
from flightstack.logs.commands.many_logs import for_each
from flightstack.logs.commands.opening import logs_in, open_flight, use_checks
from flightstack.logs.errors import LogFileError
from flightstack.logs.facts.merging import merge_parts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.progress import progress
from flightstack.logs.text.summary_text import one_line, page
from flightstack.printable import printable


def _flight_facts(flight: Flight) -> Facts:
    return summarise(flight, run_checks(flight))


def _part_facts(path: Path, system: int | None, done: Progress) -> Iterator[tuple[Facts, int]]:
    """Yield the facts of each part of a large log, and where it starts; all of one vehicle."""
    chosen = system
    for part in read_parts(path, progress=done):
        flight = Flight(part.log, chosen)
        if chosen is None and flight.vehicle is not None:
            chosen = flight.vehicle.system
        yield _flight_facts(flight), part.start


def summary_of(path: Path, system: int | None) -> Facts:
    """Return the facts of one log; of a large one part by part."""
    if not is_large(path):
        return _flight_facts(open_flight(path, system))
    with progress(path.name, path.stat().st_size) as done:
        return merge_parts(_part_facts(path, system, done))


def _say(facts: Facts, *, as_json: bool, in_a_row: bool) -> None:
    if as_json:
        print(json.dumps(facts))
    else:
        print(one_line(facts) if in_a_row else page(facts))


def run(arguments: Namespace) -> int:
    """Print the summary of every log; those that cannot be read do not stop the others."""
    use_checks(arguments)
    logs = [log for path in arguments.paths for log in logs_in(path)]
    in_a_row = len(logs) > 1 or any(path.is_dir() for path in arguments.paths)
    if not in_a_row:
        _say(summary_of(logs[0], arguments.system), as_json=arguments.json, in_a_row=False)
        return 0
    work = partial(summary_of, system=arguments.system)
    exit_code = 0
    with progress("logs", len(logs)) as done:
        answers = for_each(work, logs, arguments.checks)
        for number, (log, facts) in enumerate(zip(logs, answers, strict=True), start=1):
            if isinstance(facts, LogFileError):
                exit_code = facts.exit_code
                if arguments.json:
                    print(json.dumps({"log": str(log), "error": str(facts)}))
                print(f"error: {printable(str(facts))}", file=sys.stderr)
            else:
                _say(facts, as_json=arguments.json, in_a_row=True)
            done(number)
    return exit_code
