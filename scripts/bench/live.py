"""Measure what a viewer costs who flies: processor time with and without it, in turns.

    python scripts/bench/live.py [--rounds 10] [--duration 20]

Flies one course in lockstep, as fast as the processes can, once with `flightstack live` listening
and once without, now the one first, now the other; prints the processor time of companion, vehicle
and viewer, the median of the ratios of all turns, and whether the setpoints were the same.
"""

import argparse
import contextlib
import os
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from flightstack.logs import read  # noqa: E402

ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
TICKS_A_S = os.sysconf("SC_CLK_TCK")
LIMIT_S = 120.0
Costs = dict[str, float]


def free_port() -> int:
    """Return a UDP port that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@contextlib.contextmanager
def started(module: str, *options: str) -> Iterator[subprocess.Popen[bytes]]:
    """Start a module; interrupt it at the end."""
    command = [sys.executable, "-m", module, *options]
    null = subprocess.DEVNULL
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=null, stderr=null, cwd=ROOT)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(LIMIT_S)


def cpu_s(process: subprocess.Popen[bytes]) -> float:
    """Return the processor time of a process so far."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_A_S


def fly(folder: Path, duration_s: float, *, watched: bool) -> tuple[Costs, list[bytes]]:
    """Fly once; processor time by process, and the setpoints' payloads."""
    ground, api = (free_port(), free_port()), (free_port(), free_port())
    log = folder / f"{watched}.tlog"
    links = (f"--gcs-link={ground[0]}:{ground[1]}", f"--api-link={api[0]}:{api[1]}")
    lockstep = ("--lockstep", "--speed-factor=0", "--camera-port=0", "--track-seed=7")
    mission = (f"--duration={duration_s}", "--no-landing", f"--log={log}")
    costs: Costs = {}
    with contextlib.ExitStack() as stack:
        begin = stack.enter_context
        viewer = None
        if watched:
            viewer = begin(started("flightstack.live", f"--connect=udpin:127.0.0.1:{ground[1]}"))
        vehicle = begin(started("sitl", *lockstep, *links))
        before = os.times()
        command = ["-m", "flightstack.companion", f"--connect=udpin:127.0.0.1:{api[1]}", *mission]
        null = subprocess.DEVNULL
        options = {"env": ENVIRONMENT, "cwd": ROOT, "timeout": LIMIT_S}
        subprocess.run([sys.executable, *command], stdout=null, stderr=null, check=False, **options)
        after = os.times()
        costs["vehicle"] = cpu_s(vehicle)
        costs["viewer"] = cpu_s(viewer) if viewer else 0.0
        spent = (after.children_user, after.children_system)
        costs["companion"] = sum(spent) - before.children_user - before.children_system
    return costs, read(log).payloads("SET_POSITION_TARGET_LOCAL_NED")


def main() -> int:
    """Fly in turns and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--duration", type=float, default=20.0, help="of OFFBOARD, vehicle seconds")
    options = parser.parse_args()
    ratios: dict[str, list[float]] = {"companion": [], "vehicle": []}
    same, viewer_s = True, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(options.rounds):
            flown = {}
            for watched in (turn % 2 == 0, turn % 2 == 1):
                flown[watched] = fly(Path(folder), options.duration, watched=watched)
            same = same and flown[True][1] == flown[False][1]
            viewer_s = flown[True][0]["viewer"]
            for role, values in ratios.items():
                values.append(flown[True][0][role] / flown[False][0][role])
            print(f"turn {turn + 1}: with {flown[True][0]}, without {flown[False][0]}", flush=True)
    for role, values in ratios.items():
        print(f"{role}: {statistics.median(values):.3f} times with a viewer, median of the turns")
    print(f"viewer: {viewer_s:.1f} s of processor time in the last turn")
    print("setpoints: the same to the last bit" if same else "setpoints: NOT the same")
    return 0 if same else 1


if __name__ == "__main__":
    raise SystemExit(main())
