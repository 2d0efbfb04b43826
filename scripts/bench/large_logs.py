#!/usr/bin/env python3
"""Measure memory and time of large logs: scripts/bench/large_logs.py --gigabytes 2 --logs 1000.

A flight of this project (`--log`, else tests/data/missed_gate.tlog) is written again and again,
each time later and as of an autopilot that has booted anew, to one log of so many gigabytes, and to
a folder of so many logs. Each command runs as a process; its peak is that of one process.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from flightstack.logs import read_bytes

ROOT = Path(__file__).resolve().parents[2]
FLIGHT = ROOT / "tests" / "data" / "missed_gate.tlog"
GAP_US = 2_000_000  # between two flights
STAMP_BYTES = 8
COMMANDS = (
    ("summary",),
    ("check",),
    ("messages",),
    ("texts",),
    ("params",),
    ("dump", "--types", "SYS_STATUS", "-o", "{folder}/part.tlog"),
    ("dump", "--types", "HEARTBEAT", "--format", "json"),
    ("export", "--format", "parquet", "-o", "{folder}/parquet"),
)


def write_again_and_again(flight: Path, path: Path, size: float) -> None:
    """Write a log's records until the file has that size, their stamps ever later."""
    data = flight.read_bytes()
    packets = read_bytes(data).packets
    raw = np.frombuffer(data, np.uint8).copy()
    places = (packets.offset - STAMP_BYTES)[:, None] + np.arange(STAMP_BYTES)
    span_us = int(packets.time_us.max() - packets.time_us.min()) + GAP_US
    copies = 0
    with path.open("wb") as file:
        while file.tell() < size:
            stamps = (packets.time_us + copies * span_us).astype(">u8")
            raw[places] = stamps.view(np.uint8).reshape(-1, STAMP_BYTES)
            file.write(raw.tobytes())
            copies += 1


def measure(*arguments: str) -> str:
    """Run a command of the logs; its wall time, processor time and the peak of its memory."""
    started_s = time.monotonic()
    command = [sys.executable, "-m", "flightstack.logs", *arguments]
    environment = {"PYTHONPATH": str(ROOT)} | os.environ
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, env=environment) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    wall_s = time.monotonic() - started_s
    cpu_s = used.ru_utime + used.ru_stime
    failed = f"  exit {process.returncode}" if process.returncode else ""
    return f"{wall_s:7.1f} s wall {cpu_s:7.1f} s cpu {used.ru_maxrss / 1024:7.0f} MB{failed}"


def main() -> None:
    """Make the logs, run the commands, print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--log", type=Path, default=FLIGHT, help="the flight that is repeated")
    parser.add_argument("--gigabytes", type=float, default=0.5, help="of one log; 0: none")
    parser.add_argument("--logs", type=int, default=100, help="in a folder; 0: none")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if given.gigabytes:
            path = folder / "large.tlog"
            write_again_and_again(given.log, path, given.gigabytes * 1e9)
            for command, *options in COMMANDS:
                filled = [option.format(folder=folder) for option in options]
                print(f"{command:9} {measure(command, str(path), *filled)}", flush=True)
            path.unlink()
        if given.logs:
            logs = folder / "logs"
            logs.mkdir()
            for number in range(given.logs):
                (logs / f"{number:04}.tlog").write_bytes(given.log.read_bytes())
            for cores in ({0}, set(range(os.cpu_count() or 1))):
                os.sched_setaffinity(0, cores)
                print(f"folder on {len(cores)} {measure('summary', str(logs))}", flush=True)


if __name__ == "__main__":
    main()
