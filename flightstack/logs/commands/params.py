"""Command: parameters and their changes."""

import json
from argparse import Namespace
from fnmatch import fnmatchcase

from flightstack.logs.errors import UnknownNameError
from flightstack.logs.flight.parameters import Change, LoggedParameters, Value, read_parameters
from flightstack.logs.given.opening import flights_of
from flightstack.logs.nearest import did_you_mean
from flightstack.printable import printable


def _chosen(names: list[str], patterns: list[str], log: str) -> list[str]:
    """Return the names that match; UnknownNameError for a pattern that matches none."""
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in names):
            hint = did_you_mean(pattern, names)
            raise UnknownNameError(f"{log} holds no parameter {pattern!r}{hint}")
    return [name for name in names if not patterns or any(fnmatchcase(name, p) for p in patterns)]


def _read(log: str, system: int | None) -> tuple[LoggedParameters, int]:
    """Return the parameters of a log, and when it starts."""
    values: dict[str, Value] = {}
    changes: list[Change] = []
    start_us: int | None = None
    for flight in flights_of(log, system):
        start_us = flight.start_us if start_us is None else start_us
        parameters = read_parameters(flight, values)
        values = parameters.values
        changes += parameters.changes
    return LoggedParameters(values=values, changes=tuple(changes)), start_us or 0


def run(arguments: Namespace) -> int:
    """Print the last value of each parameter, and what changed."""
    parameters, start_us = _read(arguments.log, arguments.system)
    names = _chosen(list(parameters.values), arguments.names, arguments.log)
    changes = [change for change in parameters.changes if change.name in set(names)]
    if arguments.changes:
        names = [name for name in names if any(change.name == name for change in changes)]
    if arguments.json:
        facts = {
            "log": arguments.log,
            "parameters": {name: parameters.values[name] for name in names},
            "changes": [
                {
                    "at_s": round((change.time_us - start_us) * 1e-6, 3),
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
        print(f"{printable(arguments.log)}: the vehicle told no parameters")
    for name in names:
        print(f"{printable(name):16} {parameters.values[name]}")
    for change in changes:
        at_s = (change.time_us - start_us) * 1e-6
        print(f"{at_s:9.2f} s  {printable(change.name)}: {change.before} to {change.after}")
    return 0
