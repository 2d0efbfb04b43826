"""Measure how fast the gymnasium environment flies, beside gym-pybullet-drones' images.

    python scripts/bench/environments.py [--images 480] [--turns 5]
                                         [--beside CHECKOUT --python PYTHON]

Prints simulated seconds for each second of processor time, of one core, from the first step to the
last, episodes that end on the way and their resets included. Ours flies to where the next gate is.
With a checkout of gym-pybullet-drones, and a Python that has what it needs, that one's HoverAviary
with RGB images (64 x 48 at its 24 Hz, velocity actions, physics at its 240 Hz) flies in turns with
ours (64 x 64 at 20 Hz, 250 Hz), and the median of the turns' ratios follows.
"""

import argparse
import os
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OURS = """
import sys, time
import numpy as np
from flightstack.gym import GatesEnv
from flightstack.gym.gates import RANGE

def steer(gate, speed_m_s=2.0):
    ahead_m = max(1.0, float(np.hypot(gate[0], gate[1])))
    velocities = np.array([*gate[:3], ahead_m * gate[3]]) * speed_m_s / ahead_m
    return (velocities - RANGE.offset) / RANGE.scale

env = GatesEnv()
_, info = env.reset(seed=0)
images = int(sys.argv[1])
began_s = time.process_time()
for _ in range(images):
    _, _, terminated, truncated, info = env.step(steer(info["gate"]))
    if terminated or truncated:
        _, info = env.reset()
print(images / 20 / (time.process_time() - began_s))
"""
THEIRS = """
import sys, time, warnings
warnings.simplefilter("ignore")
import numpy as np
from gym_pybullet_drones.envs.HoverAviary import HoverAviary
from gym_pybullet_drones.utils.enums import ActionType, ObservationType

env = HoverAviary(obs=ObservationType.RGB, act=ActionType.VEL, ctrl_freq=24, pyb_freq=240)
env.reset(seed=0)
images = int(sys.argv[1])
action = np.array([[0.1, 0.0, 0.1, 0.2]], np.float32)
began_s = time.process_time()
for _ in range(images):
    observed, _, terminated, truncated, _ = env.step(action)
    if terminated or truncated:
        env.reset()
assert observed.shape == (1, 48, 64, 4)
print(images / 24 / (time.process_time() - began_s))
"""


def measure(python: str, folder: Path, program: str, images: int) -> float:
    """Fly once; simulated seconds a second of processor time."""
    ran = subprocess.run(
        [python, "-c", program, str(images)],
        env=os.environ | {"PYTHONPATH": str(folder), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if ran.returncode != 0:
        sys.exit(f"environments.py: {ran.stderr.strip().splitlines()[-1]}")
    return float(ran.stdout.splitlines()[-1])


def main() -> None:
    """Measure in turns, and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--images", type=int, default=480, metavar="N", help="of a turn (480)")
    parser.add_argument("--turns", type=int, default=5, metavar="N", help="(5)")
    parser.add_argument("--beside", type=Path, metavar="CHECKOUT", help="of gym-pybullet-drones")
    parser.add_argument("--python", metavar="PYTHON", help="that has what it needs")
    options = parser.parse_args()
    if (options.beside is None) != (options.python is None):
        parser.error("--beside and --python go together")
    ours, theirs = [], []
    for _ in range(options.turns):
        ours.append(measure(sys.executable, ROOT, OURS, options.images))
        if options.beside is not None:
            theirs.append(measure(options.python, options.beside, THEIRS, options.images))
    print(f"flightstack/Gates-v0: {statistics.median(ours):.1f} s a second")
    if theirs:
        ratio = statistics.median(one / other for one, other in zip(ours, theirs, strict=True))
        print(f"gym-pybullet-drones:  {statistics.median(theirs):.1f} s a second")
        print(f"ratio: {ratio:.1f}")


if __name__ == "__main__":
    main()
