"""Command: status texts."""

import json
from argparse import Namespace

from flightstack.logs.facts.summary import text_facts
from flightstack.logs.given.opening import flights_of


def run(arguments: Namespace) -> int:
    """Print every status text with its time and source."""
    start_us: int | None = None
    for flight in flights_of(arguments.log, arguments.system):
        start_us = flight.start_us if start_us is None else start_us
        shift_s = (flight.start_us - start_us) * 1e-6
        for text, facts in zip(flight.texts, text_facts(flight), strict=True):
            at_s = round(facts["at_s"] + shift_s, 3)
            if arguments.json:
                print(json.dumps({**facts, "at_s": at_s}))
            else:
                print(f"{at_s:9.2f} s  {text.source:>7}  {text.level:9}  {text.text}")
    return 0
