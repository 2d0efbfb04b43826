"""Command: two logs side by side."""

import json
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flightstack.logs.checks import run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.parameters import read_parameters
from flightstack.logs.given.opening import open_flight
from flightstack.printable import printable

SKIPPED = ("log", "texts", "modes", "armed", "links", "damage", "checks", "failsafes", "counts")


def _flat(facts: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the plain values of nested facts, as name.name: value."""
    for key, value in facts.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        elif not isinstance(value, list):
            yield prefix + key, value


def _facts(path: Path, system: int | None) -> tuple[Facts, Facts]:
    """Return the facts to compare, and the parameters."""
    flight = open_flight(path, system)
    summary = summarise(flight, run_checks(flight))
    chosen = {key: value for key, value in summary.items() if key not in SKIPPED}
    facts = dict(_flat(chosen))
    facts |= {f"messages.{name}": count for name, count in summary["counts"].items()}
    facts |= {f"check.{check['name']}": check["level"] for check in summary["checks"]}
    return facts, dict(read_parameters(flight).values)


def _difference(one: Any, other: Any) -> Any:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (one, other))
    return round(other - one, 6) if numbers else None


def side_by_side(one: Facts, other: Facts) -> list[Facts]:
    """Return every fact of either log with both values and their difference."""
    return [
        {
            "name": name,
            "a": one.get(name),
            "b": other.get(name),
            "difference": _difference(one.get(name), other.get(name)),
        }
        for name in dict.fromkeys([*one, *other])
    ]


def _said(value: Any) -> str:
    return "-" if value is None else printable(str(value))


def run(arguments: Namespace) -> int:
    """Print what differs, and what is alike."""
    one, one_parameters = _facts(arguments.log, arguments.system)
    other, other_parameters = _facts(arguments.other, arguments.system)
    rows = side_by_side(one, other)
    changed = side_by_side(one_parameters, other_parameters)
    changed = [row for row in changed if row["a"] != row["b"]]
    if arguments.json:
        facts = {"a": str(arguments.log), "b": str(arguments.other)}
        print(json.dumps({**facts, "facts": rows, "parameters": changed}))
        return 0
    print(f"A  {printable(str(arguments.log))}\nB  {printable(str(arguments.other))}")
    for row in [*rows, *changed]:
        mark = " " if row["a"] == row["b"] else "*"
        step = f"  ({row['difference']:+g})" if row["difference"] else ""
        print(
            f"{mark} {printable(row['name']):42} {_said(row['a']):>22} {_said(row['b']):>22}{step}"
        )
    return 0
