"""Fly one course and show it: what `scripts/fly` runs."""

import argparse
import json
import signal
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from flightstack.arguments.parser import OptionParser
from flightstack.errors import FlightstackError, UsageError
from flightstack.launch.processes import Stream, programs, started
from flightstack.launch.px4 import held_ports, prepared_px4
from flightstack.launch.request import GIVES_UP, FlightRequest
from flightstack.launch.result import FlightResult, noise_m

PROGRAM = "scripts/fly"
PARTS = ("strategy", "perception", "policy", "pilot")  # that a user may bring
DID_NOT_FLY = "did not fly"


def main(argv: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Fly; the companion's exit code is the command's."""
    options = build_parser(program).parse_args(argv)
    try:
        request = _request(options)
        with tempfile.TemporaryFile("w+") as output:
            exit_code = _fly(request, output if options.json else None, program)
            if options.json:
                output.seek(0)
                print(_result_line(output.read(), request, exit_code))
            return exit_code
    except FlightstackError as error:
        print(f"{program}: {error}", file=sys.stderr)
        return error.exit_code


def _request(options: argparse.Namespace) -> FlightRequest:
    return FlightRequest(
        laps=options.laps,
        track_seed=options.track_seed,
        noise=options.noise,
        model=options.model,
        speed_factor=0.0 if options.fast else options.speed_factor,
        px4=_px4_of(options),
        px4_folder=options.px4_folder,
        vehicle_options=(
            *("-q", f"--seed={options.seed}"),
            *(f"--condition={change}" for change in options.condition),
        ),
        companion_options=(
            *(*GIVES_UP, f"--seed={options.seed}"),
            *(f"--{part}={name}" for part in PARTS if (name := getattr(options, part))),
            *(() if options.log is None else (f"--log={options.log}",)),
            *(f"--{name}" for name in ("json", "record-frames") if _is_on(options, name)),
        ),
    )


def _is_on(options: argparse.Namespace, switch: str) -> bool:
    return bool(getattr(options, switch.replace("-", "_")))


def _fly(request: FlightRequest, output: Stream, program: str) -> int:
    """Fly with the processes' words on the terminal; signals are for the companion."""
    with held_ports(request) as ports, prepared_px4(request, ports) as px4:
        both = programs(request, ports, companion=(output, None))
        with started(*both, None if px4 is None else px4.program) as pair:
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, pair.pass_on)
            exit_code = pair.wait()
            died = None if px4 is None else px4.explain_end(pair)
            if died is not None:
                print(f"{program}: {died}", file=sys.stderr)
            return exit_code


def _result_line(output: str, request: FlightRequest, exit_code: int) -> str:
    result = FlightResult.parse(output, request)
    if result is not None:
        return result.to_json()
    noise = None if exit_code == UsageError.exit_code else noise_m(request)
    return json.dumps({"outcome": DID_NOT_FLY, "track_seed": request.track_seed, "noise": noise})


def _px4_of(options: argparse.Namespace) -> Path | None:
    if options.autopilot == "px4" and options.px4 is None:
        raise UsageError("--autopilot px4 needs --px4 PATH: PX4's build folder or its binary")
    if options.autopilot != "px4" and (options.px4 or options.px4_folder):
        raise UsageError("--px4 and --px4-folder: only with --autopilot px4")
    px4: Path | None = options.px4
    return px4


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(
        prog=program, description="Fly one course in simulation and say what happened."
    )
    add = parser.add_argument
    add("--laps", type=int, default=1, help="laps of 8 gates (default 1)")
    add("--track-seed", type=int, default=0, help="which track (default 0)")
    add(
        *("--noise",),
        default="1.0,2.0",
        metavar="GRN,GHN",
        help="noise of the gates' radius and height in m (default 1.0,2.0)",
    )
    add("--model", help="which model flies (default: the companion's)")
    add("--strategy", help="how it decides (default: the model's)")
    add("--perception", metavar="NAME", help="your own: see docs/bring-your-own.md")
    add("--policy", metavar="NAME", help="your own")
    add("--pilot", metavar="NAME", help="your own, in place of model, perception, policy, strategy")
    add("--seed", type=int, default=0, help="of light, sensors and sampling (default 0)")
    add(
        *("--condition",),
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="of the day, as camera.latency_s=0.1: see docs/conditions.md",
    )
    speed = parser.add_mutually_exclusive_group()
    speed.add_argument(
        "--speed-factor", type=float, default=1.0, help="times real time (default 1)"
    )
    speed.add_argument("--fast", action="store_true", help="as fast as possible")
    add("--autopilot", choices=("emulated", "px4"), default="emulated", help="who flies")
    add("--px4", type=Path, metavar="PATH", help="build folder or binary of a real PX4")
    add("--px4-folder", type=Path, metavar="DIR", help="where PX4 runs and leaves its logs")
    add("--log", type=Path, metavar="PATH", help="tlog (default logs/companion-<UTC>.tlog)")
    add("--record-frames", action="store_true", help="keep each frame as PNG, in LOG.frames")
    add("--json", action="store_true", help="last line of output: the result as one JSON object")
    return parser
