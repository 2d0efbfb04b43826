"""Fly a course while hostile datagrams rain on the vehicle, and say what they did.

    python scripts/bench/hostile.py [--datagrams 1000000] [--seed 0] [--signed] [--laps 3]

Flies the same course in lockstep twice: undisturbed, then under attack on both links, again and
again until all datagrams are delivered. With --signed, vehicle and companion share a key, and the
datagrams may be anything, honest orders and replayed packets among them.
"""

import argparse
import contextlib
import json
import secrets
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import STDOUT
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from flightstack.launch.instances import free_instance  # noqa: E402
from flightstack.launch.ports import Ports  # noqa: E402
from flightstack.launch.processes import Pair, programs, started  # noqa: E402
from flightstack.launch.request import FlightRequest  # noqa: E402
from scripts.bench.attacks.hostile_datagrams import Generator  # noqa: E402
from scripts.bench.attacks.hostile_sockets import VEHICLE_PORTS, Attack, Observer  # noqa: E402

BATCH = 64
OFFBOARD = 6 << 16
MAX_GROWTH = 1.05  # of resident memory
LIMIT_S = 3600.0  # wall time


@dataclass(slots=True)
class Flight:
    """What is known of one flight."""

    result: dict[str, Any] = field(default_factory=dict)  # as the companion tells
    delivered: int = 0
    dropped: int = 0
    modes: Counter[int] = field(default_factory=Counter)  # custom_mode of heartbeats under attack
    rss_before_kb: int = 0
    rss_after_kb: int = 0
    vehicle_code: int | None = None
    said: str = ""

    @property
    def refused(self) -> str:
        """The vehicle's own count."""
        lines = [line for line in self.said.splitlines() if "refused in all: " in line]
        return lines[-1].partition("refused in all: ")[2] if lines else "nothing"


def fly(options: argparse.Namespace, count: int, seed: int, folder: Path) -> Flight:
    """Fly once; under attack by up to `count` datagrams."""
    flight, observer = Flight(), Observer()
    with free_instance() as instance, contextlib.ExitStack() as stack:
        observer.system = instance + 1
        generator = Generator(seed, system=instance + 1, orders=options.signed)
        request = request_of(options, instance, observer, folder)
        said, told = (
            stack.enter_context((folder / name).open("wb"))
            for name in ("vehicle.txt", "companion.txt")
        )
        both = programs(
            request,
            Ports.of_instance(instance),
            vehicle=(said, STDOUT),
            companion=(told, STDOUT),
        )
        pair = stack.enter_context(started(*both))
        attack = stack.enter_context(contextlib.closing(Attack(generator, instance)))
        watch(flight, observer, attack, generator, pair, count)
        pair.vehicle.terminate()
        flight.vehicle_code = pair.vehicle.wait(30.0)
        flight.said = (folder / "vehicle.txt").read_text()
        last_line = (folder / "companion.txt").read_text().rstrip().rpartition("\n")[2]
        flight.result = json.loads(last_line) if last_line.startswith("{") else {}
    observer.socket.close()
    return flight


def watch(
    flight: Flight,
    observer: Observer,
    attack: Attack,
    generator: Generator,
    pair: Pair,
    count: int,
) -> None:
    """Attack from OFFBOARD to the end of the course; then wait for the landing."""
    vehicle, companion = pair.vehicle, pair.companion
    deadline_s = time.monotonic() + LIMIT_S
    before: Counter[int] = Counter()
    while companion.poll() is None and vehicle.poll() is None and time.monotonic() < deadline_s:
        under_attack = flight.rss_before_kb > 0 and not observer.is_over
        observer.look(generator, flight.modes if under_attack else before)
        if observer.mode != OFFBOARD or observer.is_over or attack.sent >= count:
            time.sleep(0.001)
        else:
            flight.rss_before_kb = flight.rss_before_kb or resident_kb(vehicle.pid)
            attack.send(min(BATCH, count - attack.sent))
            flight.rss_after_kb = resident_kb(vehicle.pid)
    _, flight.dropped = attack.queue()
    flight.delivered = attack.sent - flight.dropped


def request_of(
    options: argparse.Namespace, instance: int, observer: Observer, folder: Path
) -> FlightRequest:
    """Say what is flown, with the observer on the ground station's link."""
    key = (f"--signing-key={folder / 'key'}",) if options.signed else ()
    return FlightRequest(
        laps=options.laps,
        track_seed=options.track_seed,
        noise=options.noise,
        speed_factor=0.0,
        vehicle_options=(f"--gcs-link={VEHICLE_PORTS[0] + instance}:{observer.port}", *key),
        companion_options=("--json", "-q", f"--log={folder / 'companion.tlog'}", *key),
    )


def resident_kb(pid: int) -> int:
    """Say how much memory a process has."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    return 0


def judge(flight: Flight, reference: Flight) -> list[str]:
    """Say what the attack has done; empty if nothing."""
    harm = []
    if flight.vehicle_code != 0 or "Traceback" in flight.said:
        harm.append(f"the vehicle ended with {flight.vehicle_code}")
    if set(flight.modes) - {OFFBOARD}:
        harm.append(f"modes {', '.join(map(hex, flight.modes))}")
    for name in ("outcome", "gates_passed", "frames"):
        if flight.result.get(name) != reference.result.get(name):
            was, is_now = reference.result.get(name), flight.result.get(name)
            harm.append(f"{name} {was} became {is_now}")
    if flight.rss_after_kb > MAX_GROWTH * flight.rss_before_kb:
        harm.append(f"resident memory grew from {flight.rss_before_kb} to {flight.rss_after_kb} kB")
    return harm


def tell(name: str, flight: Flight, seconds: float) -> None:
    """Print one flight."""
    result = flight.result
    print(f"{name}: {result.get('outcome')}, gates {result.get('gates_passed')}", end=" ")
    print(f"of {result.get('gates_total')}, {result.get('frames')} frames, {seconds:.0f} s")
    if flight.delivered:
        growth = flight.rss_after_kb / flight.rss_before_kb - 1.0
        print(f"  delivered {flight.delivered}, dropped by the system {flight.dropped}")
        print(f"  modes seen {', '.join(f'{mode:#x}' for mode in flight.modes)}")
        print(f"  resident memory {flight.rss_before_kb} kB -> {flight.rss_after_kb} kB", end=" ")
        print(f"({growth:+.1%})")
        print(f"  refused: {flight.refused}", flush=True)


def parse_arguments(argv: list[str]) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="hostile.py", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--datagrams", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0, help="of the datagrams")
    parser.add_argument("--signed", action="store_true", help="with a key, against all orders")
    parser.add_argument("--laps", type=int, default=3)
    parser.add_argument("--track-seed", type=int, default=0)
    parser.add_argument("--noise", default="1.0,2.0")
    return parser.parse_args(argv)


def main(argv: list[str] | None = None) -> int:
    """Fly undisturbed, then under attack; 1 if that made a difference."""
    options = parse_arguments(sys.argv[1:] if argv is None else argv)
    harm: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "key").write_text(secrets.token_hex(32))
        started_s = time.monotonic()
        reference = fly(options, 0, 0, folder)
        tell("undisturbed", reference, time.monotonic() - started_s)
        left, seed = options.datagrams, options.seed
        while left > 0 and not harm:
            started_s = time.monotonic()
            flight = fly(options, left, seed, folder)
            tell(f"under attack (seed {seed})", flight, time.monotonic() - started_s)
            harm = judge(flight, reference)
            left, seed = left - max(1, flight.delivered), seed + 1
    print(f"harm: {'; '.join(harm) or 'none'}")
    return 1 if harm else 0


if __name__ == "__main__":
    sys.exit(main())
