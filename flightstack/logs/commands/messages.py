"""Command: every message type by source, with count, rate, first and last."""

import json
from argparse import Namespace
from collections.abc import Iterable
from pathlib import Path

from flightstack.logs.columns.reading import read
from flightstack.logs.columns.segments import is_large, read_parts
from flightstack.logs.facts.messages import joined_message_facts, message_facts
from flightstack.logs.facts.values import Facts
from flightstack.logs.progress import progress


def _of_log(arguments: Namespace) -> Iterable[Facts]:
    return message_facts(read(arguments.log, system=arguments.system))


def _of_parts(arguments: Namespace) -> Iterable[Facts]:
    """Return the facts of a large log, part by part."""
    with progress(arguments.log, Path(arguments.log).stat().st_size) as done:
        logs = (part.log for part in read_parts(arguments.log, report=done))
        return joined_message_facts(log.select(system=arguments.system) for log in logs)


def run(arguments: Namespace) -> int:
    """Print the table of types."""
    rows = _of_parts(arguments) if is_large(arguments.log) else _of_log(arguments)
    facts = sorted(rows, key=lambda each: -each["count"])
    if arguments.json:
        print(json.dumps({"log": arguments.log, "messages": facts}))
        return 0
    width = max((len(each["type"]) for each in facts), default=4)
    print(f"{'type':{width}}  source   count     rate      first       last")
    for each in facts:
        source = f"{each['system']}/{each['component']}"
        rate = f"{each['rate_hz']:.1f} Hz" if each["rate_hz"] is not None else "-"
        span = f"{each['first_s']:9.2f} s {each['last_s']:9.2f} s"
        print(f"{each['type']:{width}}  {source:>7} {each['count']:7d} {rate:>9} {span}")
    return 0
