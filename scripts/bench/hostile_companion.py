"""Fly courses while the companion's link and camera are fed hostile input; say what that did.

    python scripts/bench/hostile_companion.py [CASE ...] [--inputs 1000000] [--seed 0]

strangers   datagrams of all kinds to its port, from other addresses than the vehicle's
camera      parts among the camera's own that are no pictures, and connections that break
vehicle     packets in the vehicle's name, from its address, with anything in their fields
liar        pictures in the camera's name with any stamp and any content

After strangers and undecodable parts the course must be flown as without them, and the companion's
memory be flat within 5 %. In the vehicle's or the camera's own name anything may be said: then
there must be no exception, and the vehicle must be on the ground in the end, disarmed.
"""

import argparse
import contextlib
import json
import random
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import STDOUT
from typing import Any

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from flightstack.launch.instances import free_instance  # noqa: E402
from flightstack.launch.ports import Ports  # noqa: E402
from flightstack.launch.processes import Pair, programs, started  # noqa: E402
from flightstack.launch.request import FlightRequest  # noqa: E402
from scripts.bench.attacks.hostile_datagrams import Generator  # noqa: E402
from scripts.bench.attacks.hostile_middle import (  # noqa: E402
    CameraMiddle,
    LinkMiddle,
    odd_part,
    random_fields,
    undecodable,
)
from scripts.bench.attacks.hostile_sockets import Attack  # noqa: E402
from scripts.bench.hostile import resident_kb  # noqa: E402

CASES = ("strangers", "camera", "vehicle", "liar")
HARMLESS = ("strangers", "camera")
CAMERA_PORT = 8090  # + instance
MAX_GROWTH = 1.05  # of resident memory
LIMIT_S = 1200.0  # wall time
PER_IMAGE = 400.0  # parts
PER_DATAGRAM = 20.0  # packets
BATCH = 64
OFFBOARD = 6 << 16


@dataclass(slots=True)
class Ended:
    """What is known of one flight."""

    result: dict[str, Any] = field(default_factory=dict)  # as the companion tells
    said: str = ""
    code: int | None = None
    sent: int = 0
    armed: bool = False
    before_kb: int = 0
    after_kb: int = 0


def fly(case: str | None, options: argparse.Namespace, folder: Path) -> Ended:
    """Fly once; undisturbed without a case."""
    ended = Ended()
    with free_instance() as instance, contextlib.ExitStack() as stack:
        companion = Ports.find().companion
        rng = random.Random(options.seed)  # noqa: S311  not for secrets: the same every time
        middle = stack.enter_context(_link_middle(case, options, companion, instance, rng))
        camera = stack.enter_context(_camera_middle(case, options, instance, rng))
        request = FlightRequest(
            laps=options.laps,
            speed_factor=options.speed_factor if case == "strangers" else 0.0,
            companion_options=(
                *("--json", "-q", f"--log={folder / 'companion.tlog'}"),
                *(() if case is None else (f"--camera={camera.uri}",)),
            ),
        )
        ports = Ports(
            vehicle_options=(f"--instance={instance}", f"--api-link=0:{middle.port}"),
            companion=companion,
        )
        said = [stack.enter_context((folder / name).open("wb")) for name in ("v.txt", "c.txt")]
        both = programs(request, ports, vehicle=(said[0], STDOUT), companion=(said[1], STDOUT))
        pair = stack.enter_context(started(*both))
        with _strangers(case, options, companion) as strangers:
            _watch(ended, pair, (middle, camera), strangers, options.inputs)
        ended.code = pair.companion.poll()
        ended.armed = middle.armed
        ended.sent = middle.sent + camera.sent + (0 if strangers is None else strangers.sent)
    ended.said = (folder / "c.txt").read_text(errors="replace")
    last = ended.said.rstrip().rpartition("\n")[2]
    ended.result = json.loads(last) if last.startswith("{") else {}
    return ended


def _link_middle(
    case: str | None, options: argparse.Namespace, companion: int, instance: int, rng: random.Random
) -> LinkMiddle:
    count = options.inputs if case == "vehicle" else 0
    return LinkMiddle(companion, lambda: random_fields(rng, instance + 1), PER_DATAGRAM, count)


def _camera_middle(
    case: str | None, options: argparse.Namespace, instance: int, rng: random.Random
) -> CameraMiddle:
    count = options.inputs if case in ("camera", "liar") else 0
    lies = [
        cv2.imencode(".png", np.frombuffer(rng.randbytes(12288), np.uint8).reshape(64, 64, 3))[1]
        for _ in range(16)
    ]

    def make() -> bytes:
        return odd_part(rng, rng.choice(lies).tobytes() if case == "liar" else undecodable(rng))

    each = 0.2 if case == "liar" else PER_IMAGE
    return CameraMiddle(CAMERA_PORT + instance, make, each, count)


@contextlib.contextmanager
def _strangers(
    case: str | None, options: argparse.Namespace, companion: int
) -> Iterator[Attack | None]:
    if case != "strangers":
        yield None
        return
    generator = Generator(options.seed, orders=True)
    with contextlib.closing(Attack(generator, 0, ports=[companion])) as attack:
        yield attack


def _watch(
    ended: Ended,
    pair: Pair,
    middles: tuple[LinkMiddle, CameraMiddle],
    strangers: Attack | None,
    inputs: int,
) -> None:
    """Attack from the first moment in OFFBOARD to the end of the flight."""
    link, camera = middles
    ends_s = time.monotonic() + LIMIT_S
    while pair.companion.poll() is None and time.monotonic() < ends_s:
        if link.mode != OFFBOARD and not link.may_begin.is_set():
            time.sleep(0.01)
            ended.before_kb = resident_kb(pair.companion.pid) or ended.before_kb
            continue
        for middle in (link, camera):
            middle.may_begin.set()
        ended.after_kb = resident_kb(pair.companion.pid) or ended.after_kb
        if strangers is None or strangers.sent >= inputs:
            time.sleep(0.01)
        else:
            strangers.send(min(BATCH, inputs - strangers.sent))


def judge(case: str, ended: Ended, reference: Ended) -> list[str]:
    """Say what is not as it should be; nothing if all is."""
    wrong = []
    if "Traceback" in ended.said or not ended.result:
        wrong.append(f"the companion ended with {ended.code}: {ended.said[-500:]!r}")
    if ended.armed:
        wrong.append("the vehicle is still armed")
    if case not in HARMLESS:
        return wrong
    for name in ("outcome", "gates_passed"):
        if ended.result.get(name) != reference.result.get(name):
            was, is_now = reference.result.get(name), ended.result.get(name)
            wrong.append(f"{name} {was} became {is_now}")
    if ended.after_kb > MAX_GROWTH * ended.before_kb:
        wrong.append(f"memory grew from {ended.before_kb} to {ended.after_kb} kB")
    return wrong


def main() -> int:
    """Fly undisturbed, then once for each case; 1 if anything was not as it should be."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--laps", type=int, default=3)
    parser.add_argument("--speed-factor", type=float, default=1.5, help="beside strangers")
    options = parser.parse_args()
    options.cases = options.cases or CASES
    if set(options.cases) - set(CASES):
        parser.error(f"cases are {', '.join(CASES)}")
    reference, wrong = Ended(), []
    for case in (None, *options.cases):
        began_s = time.monotonic()
        with tempfile.TemporaryDirectory() as name:
            ended = fly(case, options, Path(name))
        reference = ended if case is None else reference
        found = [] if case is None else judge(case, ended, reference)
        wrong += found
        result, growth = ended.result, ended.after_kb / max(1, ended.before_kb) - 1.0
        print(f"{case or 'undisturbed'}: {result.get('outcome')}, code {ended.code},", end=" ")
        print(f"gates {result.get('gates_passed')}, {ended.sent} inputs, memory", end=" ")
        print(f"{growth:+.1%}, {time.monotonic() - began_s:.0f} s; {found or 'as it should be'}")
        sys.stdout.flush()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
