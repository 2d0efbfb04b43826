"""Command: parameters and their changes."""

import json
from argparse import Namespace
from fnmatch import fnmatchcase

from flightstack.logs.commands.opening import open_flight
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.flight.parameters import read_parameters
from flightstack.logs.nearest import did_you_mean
from flightstack.printable import printable


def _chosen(names: list[str], patterns: list[str], log: str) -> list[str]:
    """Return the names that match; UnknownNameError for a pattern that matches none."""
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            hint = did_you_mean(pattern, names)
            raise UnknownNameError(f"{log} holds no parameter {pattern!r}{hint}")
    return [name for name in names if not patterns or any(fnmatchcase(name, p) for p in patterns)]


def run(arguments: Namespace) -> int:
    """Print the last value of each parameter, and what changed."""
    flight = open_flight(arguments.log, arguments.system)
    parameters = read_parameters(flight)
    names = _chosen(list(parameters.values), arguments.names, flight.log.name)
    changes = [change for change in parameters.changes if change.name in set(names)]
    if arguments.changes:
        names = [name for name in names if any(change.name == name for change in changes)]
    if arguments.json:
        facts = {
            "log": flight.log.name,
            "parameters": {name: parameters.values[name] for name in names},
            "changes": [
                {
                    "at_s": round(flight.seconds(change.time_us), 3),
                    "name": change.name,
                    "before": change.before,
                    "after": change.after,
                }
                for change in changes
            ],
        }
        print(json.dumps(facts))
        return 0
    if not parameters.values:
        print(f"{printable(flight.log.name)}: the vehicle told no parameters")
    for name in names:
        print(f"{printable(name):16} {parameters.values[name]}")
    for change in changes:
        at_s = flight.seconds(change.time_us)
        print(f"{at_s:9.2f} s  {printable(change.name)}: {change.before} to {change.after}")
    return 0
