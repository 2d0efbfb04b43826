"""Command: what happened, on one page; one line a log for folders."""

import json
import sys
from argparse import Namespace
from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.commands.opening import logs_in, open_flight, use_checks
from flightstack.logs.errors import LogFileError
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.printable import printable
from flightstack.logs.text.summary_text import one_line, page


def summary_of(path: Path, system: int | None) -> Facts:
    """Return the facts of one log."""
    flight = open_flight(path, system)
    return summarise(flight, run_checks(flight))


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
    exit_code = 0
    for log in logs:
        try:
            facts = summary_of(log, arguments.system)
        except LogFileError as error:
            exit_code = error.exit_code
            if arguments.json:
                print(json.dumps({"log": str(log), "error": str(error)}))
            print(f"error: {printable(str(error))}", file=sys.stderr)
        else:
            _say(facts, as_json=arguments.json, in_a_row=True)
    return exit_code
