#!/usr/bin/env python3
"""Measure the log reader beside pymavlink, in one run: python scripts/bench/logs.py [LOG].

Without a log, one is made of the messages and rates of a flight. Every figure is the best of some
rounds, of CPU time unless it says wall, taken in turns, so that a busy machine slows both alike.
`--fuzz N` reads N damaged inputs instead.
"""

import argparse
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pymavlink import mavutil
from pymavlink.dialects.v20 import all as mavlink

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from flightstack.logs import read, read_bytes
from flightstack.logs.tlog.chain import find_chained
from flightstack.logs.tlog.packet_search import Bytes, Positions
from flightstack.logs.tlog.packets import TIMESTAMP
from flightstack.logs.tlog.source import MemorySource

MESSAGES = 200_000
MANY = 2_000_000
START_US = 1_700_000_000_000_000
PYTHON = sys.executable
# message and rate on the link to the companion
RATES = {
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 100,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_HIGHRES_IMU: 50,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 50,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 30,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: 30,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: 20,
    mavlink.MAVLINK_MSG_ID_DEBUG_FLOAT_ARRAY: 20,
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 10,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 5,
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1,
}


def made_payload(msgid: int, rng: np.random.Generator) -> bytes:
    """Return a payload of plausible numbers: floats around one, small integers."""
    definition = mavlink.mavlink_map[msgid]
    values: list[object] = []
    for value in definition.unpacker.unpack(bytes(definition.unpacker.size)):
        if isinstance(value, bytes):
            values.append(b"decision")
        elif isinstance(value, float):
            values.append(float(rng.normal()))
        else:
            values.append(int(rng.integers(0, 100)))
    return bytes(definition.unpacker.pack(*values))


def make_log(path: Path, count: int) -> None:
    """Write a log of so many messages, in the mixture that a companion's link has."""
    rng = np.random.default_rng(1)
    ids = np.repeat(list(RATES), list(RATES.values()))
    payloads = {msgid: [made_payload(msgid, rng) for _ in range(64)] for msgid in RATES}
    order = rng.permutation(ids)
    with path.open("wb") as file:
        for index in range(count):
            msgid = int(order[index % len(order)])
            definition = mavlink.mavlink_map[msgid]
            payload = payloads[msgid][index % 64].rstrip(b"\0") or b"\0"
            sender = (index % 256, 1, 1)  # with its sequence number
            identity = (msgid & 0xFFFF, msgid >> 16)
            head = struct.pack("<BBBB3BHB", 0xFD, len(payload), 0, 0, *sender, *identity)
            crc = mavlink.x25crc(head[1:] + payload + bytes([definition.crc_extra])).crc
            stamp = struct.pack(">Q", START_US + index * 2500)
            file.write(stamp + head + payload + struct.pack("<H", crc))


def cpu_s(work: Callable[[], object]) -> float:
    """Return the CPU time of this process for some work."""
    started = time.process_time()
    work()
    return time.process_time() - started


def child_s(command: list[str], output: Path, bytecode: Path) -> tuple[float, float]:
    """Return the CPU and the wall time of a command from its start to its end.

    Both sides find their modules compiled, as they are after pip has installed them.
    """
    environment = {
        **os.environ,
        "PYTHONPYCACHEPREFIX": str(bytecode),
        "PYTHONDONTWRITEBYTECODE": "",
        "PYTHONUNBUFFERED": "",  # or mavlogdump.py writes every line by itself
    }
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    started = time.perf_counter()
    with output.open("wb") as file:
        subprocess.run(command, stdout=file, check=True, env=environment)
    wall = time.perf_counter() - started
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall


def recv_match(path: Path, opener: Callable[[str], object]) -> int:
    """Read a log message by message with pymavlink."""
    log = opener(str(path))
    count = 0
    while log.recv_match() is not None:  # type: ignore[attr-defined]
        count += 1
    return count


def read_all(path: Path) -> int:
    """Read a log with every checksum, and decode every message that is known."""
    log = read(path)
    log.load(log.counts)
    return len(log)


def side_by_side(
    name: str, theirs: Callable[[], object], ours: Callable[[], object], rounds: int
) -> None:
    """Print the best CPU times of both, taken in turns, and their ratio."""
    pairs = [(cpu_s(theirs), cpu_s(ours)) for _ in range(rounds)]
    slow, fast = (min(column) for column in zip(*pairs, strict=True))
    print_pair(name, slow, fast)


def print_pair(name: str, slow: float, fast: float) -> None:
    """Print two times and their ratio."""
    print(f"{name:58} {slow:7.3f} s  {fast:7.3f} s  {slow / fast:5.1f}x")


def measure_reading(path: Path, rounds: int) -> None:
    """Compare whole reads."""

    def stream() -> int:
        return recv_match(path, lambda name: mavutil.mavlogfile(name, robust_parsing=True))

    def mapped() -> int:
        return recv_match(path, mavutil.mavlink_connection)

    print(f"{'':58} {'pymavlink':>9}  {'ours':>9}  ratio")
    ours = lambda: read(path)  # noqa: E731
    side_by_side("whole read, every checksum: mavlogfile.recv_match", stream, ours, rounds)
    side_by_side("whole read, every checksum: mavmmaplog.recv_match", mapped, ours, rounds)
    everything = lambda: read_all(path)  # noqa: E731
    side_by_side("and every field of every message decoded", mapped, everything, rounds)


def measure_dump(path: Path, folder: Path, rounds: int) -> None:
    """Compare `dump --types ATTITUDE` with mavlogdump.py: whole commands, and without start-up."""
    bytecode, nothing = folder / "bytecode", folder / "nothing.txt"
    mavlogdump = str(Path(PYTHON).with_name("mavlogdump.py"))
    empty = folder / "one.tlog"
    empty.write_bytes(first_record(path))
    commands = {
        "theirs": [PYTHON, mavlogdump, "--types", "ATTITUDE"],
        "ours": [PYTHON, "-m", "flightstack.logs", "dump", "--types", "ATTITUDE"],
    }
    outputs = {who: folder / f"{who}.txt" for who in commands}
    taken: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for _ in range(rounds):
        for what, log in (("whole", path), ("start", empty)):
            for who, command in commands.items():
                output = outputs[who] if what == "whole" else nothing
                times = child_s([*command, str(log)], output, bytecode)
                taken.setdefault((who, what), []).append(times)
    for column, clock in enumerate(("CPU", "wall")):
        best = {key: min(each[column] for each in times) for key, times in taken.items()}
        slow, fast = best["theirs", "whole"], best["ours", "whole"]
        print_pair(f"dump --types ATTITUDE, {clock}: from start to end", slow, fast)
        slow, fast = slow - best["theirs", "start"], fast - best["ours", "start"]
        print_pair(f"dump --types ATTITUDE, {clock}: without its start-up", slow, fast)
    for code in ("pass", "import numpy"):
        starts = [child_s([PYTHON, "-c", code], nothing, bytecode) for _ in range(rounds)]
        cpu, wall = (min(column) for column in zip(*starts, strict=True))
        print(f"  python -c {code!r}: {cpu:.3f} s CPU, {wall:.3f} s wall")
    theirs, ours = (outputs[who].read_bytes() for who in commands)
    same, rows = theirs == ours, ours.count(b"\n")
    print(f"  {rows} rows, {'the same' if same else 'NOT THE SAME'} from both")


def first_record(path: Path) -> bytes:
    """Return the first record of a log."""
    packet_end = int(read(path).packets.end[0])
    return path.read_bytes()[:packet_end]


def measure_summary(path: Path, rounds: int) -> None:
    """Print the wall and CPU time of a summary after start-up."""
    from flightstack.logs.facts.whole_log import summary_of  # noqa: PLC0415

    summary_of(path, None)  # imports and tables
    walls, cpus = [], []
    for _ in range(rounds):
        started = time.perf_counter()
        cpus.append(cpu_s(lambda: summary_of(path, None)))
        walls.append(time.perf_counter() - started)
    print(f"summary after start-up: {min(walls):.3f} s wall, {min(cpus):.3f} s CPU")


def measure_memory(folder: Path) -> None:
    """Print the most memory of a process that summarises two million messages."""
    path = folder / "many.tlog"
    make_log(path, MANY)
    code = (
        "import sys; from pathlib import Path;"
        "from flightstack.logs.commands.summary import summary_of;"
        "facts = summary_of(Path(sys.argv[1]), None);"
        "status = Path('/proc/self/status').read_text();"
        "print(facts['messages'], int(status.split('VmHWM:')[1].split()[0]) / 1024)"
    )
    ran = subprocess.run(
        [PYTHON, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    messages, megabytes = ran.stdout.split()
    size = path.stat().st_size / 2**20
    print(f"summary of {messages} messages ({size:.0f} MiB): {float(megabytes):.0f} MiB of memory")


def damaged(clean: Bytes, edges: Positions, rng: np.random.Generator) -> Bytes:
    """Return a piece of a log, of whole records or not, perhaps with bytes hit; or noise."""
    start, length = int(rng.integers(0, len(clean) - 1500)), int(rng.integers(0, 1500))
    first, last = np.searchsorted(edges, (start, start + length))
    is_whole = rng.random() < 0.5
    data = clean[edges[first] : edges[last]] if is_whole else clean[start : start + length]
    if rng.random() < 0.1:
        return rng.integers(0, 256, size=len(data), dtype=np.uint8)
    hit = data.copy()
    if len(data):
        places = rng.integers(0, len(data), size=int(rng.integers(0, 30) * rng.integers(0, 2)))
        hit[places] = rng.choice([0xFD, 0xFE, 0, 255, 1, 7], size=len(places))
    return hit


def fuzz(count: int, seed: int) -> None:
    """Read so many damaged inputs, whole and along their chain of records.

    An exception ends the run, and so does a chain that tells of other packets than the whole read.
    """
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.tlog"
        make_log(path, 2000)
        clean, packets = np.fromfile(path, dtype=np.uint8), read(path).packets
    edges = np.append(packets.offset - TIMESTAMP, len(clean))
    asked = sorted(RATES)[:4]
    found = chained = 0
    for index in range(1, count + 1):
        data = damaged(clean, edges, rng)
        log = read_bytes(data)
        log.load(log.counts)
        found += len(log) if log.damage.lost_bytes <= len(data) else 0
        along = find_chained(MemorySource(data), asked)
        if along is not None:
            chained += 1
            same = log.packets.offset[np.isin(log.packets.msgid, asked)]
            if not np.array_equal(along.offset, same):
                raise AssertionError(f"input {index} of seed {seed}: {along.offset}, not {same}")
        if index % 5000 == 0 or index == count:
            print(f"{index} inputs, {found} packets, {chained} unbroken, no exception", flush=True)


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("log", nargs="?", type=Path, help="a flight log; default: one is made")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--memory", action="store_true", help="with two million messages too")
    parser.add_argument("--fuzz", type=int, metavar="N", help="read N damaged inputs instead")
    parser.add_argument("--seed", type=int, default=9, help="of the damaged inputs")
    arguments = parser.parse_args()
    if arguments.fuzz:
        fuzz(arguments.fuzz, arguments.seed)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = arguments.log or folder / "made.tlog"
        if arguments.log is None:
            make_log(path, MESSAGES)
        print(f"{len(read(path))} messages, {path.stat().st_size / 2**20:.1f} MiB, CPU time")
        measure_reading(path, arguments.rounds)
        measure_dump(path, folder, arguments.rounds)
        measure_summary(path, arguments.rounds)
        if arguments.memory:
            measure_memory(folder)


if __name__ == "__main__":
    main()
