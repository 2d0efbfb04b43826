"""Command: health checks, worst first."""

import json
from argparse import Namespace

from flightstack.logs.checks import Level, run_checks
from flightstack.logs.commands.opening import open_flight, use_checks
from flightstack.logs.text.summary_text import check_lines


def run(arguments: Namespace) -> int:
    """Print what every check finds; with --strict exit 1 if one finds an error."""
    use_checks(arguments)
    flight = open_flight(arguments.log, arguments.system)
    findings = run_checks(flight)
    if arguments.json:
        facts = [finding.as_facts() for finding in findings]
        print(json.dumps({"log": flight.log.name, "checks": facts}))
    else:
        print("\n".join(check_lines(finding.as_facts() for finding in findings)))
    failed = any(finding.level is Level.ERROR for finding in findings)
    return 1 if arguments.strict and failed else 0
