"""Command: what happened, on one page; one line a log for folders."""

import json
import sys
from argparse import Namespace
from functools import partial

from flightstack.logs.errors import LogFileError
from flightstack.logs.facts.values import Facts
from flightstack.logs.facts.whole_log import summary_of
from flightstack.logs.given.many_logs import for_each
from flightstack.logs.given.opening import logs_in, use_checks
from flightstack.logs.progress import progress
from flightstack.logs.text.summary_text import one_line, page
from flightstack.printable import printable


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
