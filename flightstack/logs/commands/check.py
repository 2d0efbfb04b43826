"""Command: health checks, worst first."""

import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.checks import Level, run_checks
from flightstack.logs.columns.segments import is_large
from flightstack.logs.facts.values import Facts
from flightstack.logs.facts.whole_log import summary_of
from flightstack.logs.given.opening import open_flight, use_checks
from flightstack.logs.text.summary_text import check_lines


def _findings(log: str, system: int | None) -> list[Facts]:
    if is_large(log):
        checks: list[Facts] = summary_of(Path(log), system)["checks"]
        return checks
    return [finding.as_facts() for finding in run_checks(open_flight(log, system))]


def run(arguments: Namespace) -> int:
    """Print what every check finds; with --strict exit 1 if one finds an error."""
    use_checks(arguments)
    findings = _findings(arguments.log, arguments.system)
    if arguments.json:
        print(json.dumps({"log": arguments.log, "checks": findings}))
    else:
        print("\n".join(check_lines(findings)))
    failed = any(finding["level"] == Level.ERROR.value for finding in findings)
    return 1 if arguments.strict and failed else 0
