"""Read a dataset of `flightstack logs dataset` with lerobot itself, and say what it found.

    LEROBOT_ENVIRONMENT/bin/python scripts/compare/lerobot_dataset.py FOLDER

Run it in an environment of its own, where lerobot is installed: it needs nothing of flightstack.
Every row is read, with its image; the exit code is 1 where a row lacks something.
"""

import sys

from lerobot.datasets.lerobot_dataset import LeRobotDataset

SHAPES = {"observation.state": (6,), "action": (4,), "uncertainty": (12,)}
IMAGE = "observation.images.front"


def main() -> int:
    """Read all rows."""
    dataset = LeRobotDataset("local/flights", root=sys.argv[1], video_backend="pyav")
    for row in dataset:
        found = {key: tuple(row[key].shape) for key in SHAPES}
        if found != SHAPES or len(row[IMAGE].shape) != 3:
            print(f"row {int(row['index'])}: {found}, image {tuple(row[IMAGE].shape)}")
            return 1
    print(f"{dataset.num_episodes} episodes, {len(dataset)} rows at {dataset.fps} Hz, all read")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
