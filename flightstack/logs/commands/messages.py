"""Command: every message type by source, with count, rate, first and last."""

import json
from argparse import Namespace

from flightstack.logs.columns.reading import read
from flightstack.logs.facts.messages import message_facts


def run(arguments: Namespace) -> int:
    """Print the table of types."""
    log = read(arguments.log, system=arguments.system)
    facts = sorted(message_facts(log), key=lambda each: -each["count"])
    if arguments.json:
        print(json.dumps({"log": log.name, "messages": facts}))
        return 0
    width = max((len(each["type"]) for each in facts), default=4)
    print(f"{'type':{width}}  source   count     rate      first       last")
    for each in facts:
        source = f"{each['system']}/{each['component']}"
        rate = f"{each['rate_hz']:.1f} Hz" if each["rate_hz"] is not None else "-"
        span = f"{each['first_s']:9.2f} s {each['last_s']:9.2f} s"
        print(f"{each['type']:{width}}  {source:>7} {each['count']:7d} {rate:>9} {span}")
    return 0
