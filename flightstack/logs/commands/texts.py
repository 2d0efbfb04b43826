"""Command: status texts."""

import json
from argparse import Namespace

from flightstack.logs.commands.opening import open_flight
from flightstack.logs.facts.summary import text_facts


def run(arguments: Namespace) -> int:
    """Print every status text with its time and source."""
    flight = open_flight(arguments.log, arguments.system)
    for text, facts in zip(flight.texts, text_facts(flight), strict=True):
        if arguments.json:
            print(json.dumps(facts))
        else:
            at_s = facts["at_s"]
            print(f"{at_s:9.2f} s  {text.source:>7}  {text.level:9}  {text.text}")
    return 0
