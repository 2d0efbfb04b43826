"""Command: status texts."""

import json
from argparse import Namespace

from flightstack.logs.commands.opening import open_flight


def run(arguments: Namespace) -> int:
    """Print every status text with its time and source."""
    flight = open_flight(arguments)
    for text in flight.texts:
        at_s = round(flight.seconds(text.time_us), 3)
        source = f"{text.system}/{text.component}"
        if arguments.json:
            facts = {"at_s": at_s, "source": source, "level": text.level, "text": text.text}
            print(json.dumps(facts))
        else:
            print(f"{at_s:9.2f} s  {source:>7}  {text.level:9}  {text.text}")
    return 0
