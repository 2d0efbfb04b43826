"""Command: a film of what the camera saw, with commands, uncertainty and gate, beside the path."""

import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.given.arguments import check_folder
from flightstack.logs.given.opening import open_flight
from flightstack.logs.seen import find_seen
from flightstack.logs.video.film import write_film


def run(arguments: Namespace) -> int:
    """Write the film and say where."""
    check_folder(arguments.frames)
    flight = open_flight(arguments.log, arguments.system)
    seen = find_seen(flight, arguments.frames)
    output: Path = arguments.output or Path(arguments.log).with_suffix(".mp4")
    write_film(flight, seen, output)
    if arguments.json:
        print(json.dumps({"written": str(output), "images": len(seen)}))
    else:
        print(f"wrote {output}: {len(seen)} images")
    return 0
