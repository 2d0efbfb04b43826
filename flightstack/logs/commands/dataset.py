"""Command: flights with recorded images as a LeRobot dataset, one episode a flight."""

import json
from argparse import Namespace

from flightstack.logs.export.episode import find_episode
from flightstack.logs.export.lerobot import write_lerobot
from flightstack.logs.given.arguments import writing
from flightstack.logs.given.opening import logs_in, open_flight


def run(arguments: Namespace) -> int:
    """Write the dataset and say where."""
    logs = [log for path in arguments.paths for log in logs_in(path)]
    episodes = [find_episode(open_flight(log, arguments.system)) for log in logs]
    with writing(arguments.output):
        write_lerobot(episodes, arguments.output, arguments.task)
    images = sum(map(len, episodes))
    if arguments.json:
        written = {"written": str(arguments.output), "episodes": len(episodes), "images": images}
        print(json.dumps(written))
    else:
        print(f"wrote {arguments.output}: {len(episodes)} episodes, {images} images")
    return 0
