"""Fly for hours of vehicle time, and say whether memory, clocks and cost stay what they were.

    python scripts/bench/soak.py [--hours 24] [--parts 24]

In lockstep, as fast as it goes, lap after lap. The time in OFFBOARD is cut into parts of equal
length; each line says, of one part, what both processes hold at its end and the processor time of
an image. Last it says how far the stamps of setpoints are from those of telemetry. The exit code
is 1 where memory has grown by more than 5 % since the first part, where the last part's images
cost more than 5 % more than the first's, or where clocks are more than an image apart.
"""

import argparse
import os
import re
import sys
import tempfile
import time
from pathlib import Path
from subprocess import STDOUT
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from flightstack.launch.ports import Ports  # noqa: E402
from flightstack.launch.processes import Pair, Process, programs, started  # noqa: E402
from flightstack.launch.request import FlightRequest  # noqa: E402
from flightstack.logs import read  # noqa: E402
from scripts.bench.hostile import resident_kb  # noqa: E402

LAP_S = 24.0  # no lap is faster
IMAGES_HZ = 20.0
MAX_GROWTH = 1.05
IMAGE_MS = 50.0
TAIL_BYTES = 2_000_000  # of the log
TICKS_HZ = os.sysconf("SC_CLK_TCK")
FLOWN = re.compile(r"^\s*(\d+\.\d+) s ", re.MULTILINE)


class Part(NamedTuple):
    """What both processes were like at the end of a part: the companion first."""

    flown_s: float  # vehicle time
    cpu_s: tuple[float, float]  # since they started
    held_kb: tuple[int, int]


def fly(options: argparse.Namespace, folder: Path) -> list[Part]:
    """Fly it all; the parts, the first of which has no length."""
    total_s = options.hours * 3600.0
    request = FlightRequest(
        laps=int(total_s / LAP_S) + 1,
        noise="0,0",
        speed_factor=0.0,
        vehicle_options=("-q",),
        companion_options=(f"--duration={total_s:g}", f"--log={folder / 'soak.tlog'}"),
    )
    said = folder / "companion.txt"
    with said.open("wb") as output, (folder / "vehicle.txt").open("wb") as other:
        both = programs(request, Ports.find(), vehicle=(other, STDOUT), companion=(output, STDOUT))
        with started(*both) as pair:
            parts = list(_watch(pair, said, total_s / options.parts))
    print(said.read_text().splitlines()[-2])
    return parts


def _watch(pair: Pair, said: Path, part_s: float) -> list[Part]:
    parts: list[Part] = []
    while pair.companion.poll() is None:
        time.sleep(0.2)
        times = FLOWN.findall(said.read_text()[-2000:])
        if times and float(times[-1]) >= len(parts) * part_s and pair.companion.poll() is None:
            parts.append(_part(pair, float(times[-1])))
            _tell(parts)
    return parts


def _part(pair: Pair, flown_s: float) -> Part:
    ours = (pair.companion, pair.vehicle)
    cpu_s = (_cpu_s(pair.companion), _cpu_s(pair.vehicle))
    held = tuple(resident_kb(process.pid) for process in ours)
    return Part(flown_s, cpu_s, (held[0], held[1]))


def _cpu_s(process: Process) -> float:
    fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_HZ


def cost_ms(before: Part, after: Part) -> tuple[float, float]:
    """Return the processor time of an image, of companion and vehicle."""
    images = (after.flown_s - before.flown_s) * IMAGES_HZ
    first, second = (
        1000 * (b - a) / images for a, b in zip(before.cpu_s, after.cpu_s, strict=True)
    )
    return first, second


def _tell(parts: list[Part]) -> None:
    if len(parts) < 2:
        return
    companion_ms, vehicle_ms = cost_ms(*parts[-2:])
    held = " and ".join(f"{kb / 1024:.1f} MiB" for kb in parts[-1].held_kb)
    print(
        f"{parts[-1].flown_s / 3600:6.2f} h: companion and vehicle hold {held}, an image costs "
        f"{companion_ms:.2f} and {vehicle_ms:.2f} ms",
        flush=True,
    )


def clocks_apart_ms(folder: Path) -> float:
    """Return how far the last setpoint's stamp is from the last telemetry's, ms."""
    log = max(folder.glob("soak*.tlog"), key=lambda path: path.stat().st_mtime)
    tail = folder / "tail.tlog"
    with log.open("rb") as file:
        file.seek(max(0, log.stat().st_size - TAIL_BYTES))
        tail.write_bytes(file.read())
    last = read(tail)
    kinds = ("SET_POSITION_TARGET_LOCAL_NED", "LOCAL_POSITION_NED")
    setpoint_ms, telemetry_ms = (float(last[kind]["time_boot_ms"][-1]) for kind in kinds)
    return abs(setpoint_ms - telemetry_ms)


def judge(parts: list[Part], apart_ms: float) -> list[str]:
    """Say what is not as it was."""
    wrong = []
    for number, who in enumerate(("companion", "vehicle")):
        first_kb, last_kb = parts[1].held_kb[number], parts[-1].held_kb[number]
        if last_kb > MAX_GROWTH * first_kb:
            wrong.append(f"the {who} grew from {first_kb} to {last_kb} kB")
        first_ms, last_ms = cost_ms(*parts[:2])[number], cost_ms(*parts[-2:])[number]
        if last_ms > MAX_GROWTH * first_ms:
            wrong.append(f"the {who}'s image cost {first_ms:.2f} ms, then {last_ms:.2f} ms")
    if apart_ms > IMAGE_MS:
        wrong.append(f"clocks are {apart_ms:g} ms apart")
    return wrong


def main() -> int:
    """Fly, and judge."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=24.0, help="of vehicle time (24)")
    parser.add_argument("--parts", type=int, default=24)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        parts = fly(options, Path(name))
        apart_ms = clocks_apart_ms(Path(name))
    if len(parts) < 3:
        sys.exit("soak.py: it ended early: no figures")
    print(f"clocks {apart_ms:g} ms apart at the end")
    wrong = judge(parts, apart_ms)
    print("; ".join(wrong) or "as it began")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
