"""Read the companion's command line, fly, print the result, return the exit code."""

import argparse
import math
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from flightstack.arguments.ending import run_command
from flightstack.arguments.parser import OptionParser
from flightstack.companion.options.camera_options import add_camera_options, camera_settings
from flightstack.errors import UsageError
from flightstack.printable import printable

if TYPE_CHECKING:
    from flightstack.companion.console import Console
    from flightstack.companion.guards.limits import FlightLimits
    from flightstack.companion.opening.steps import FlightPlan
    from flightstack.companion.piloting.protocols import GuardedPilot
    from flightstack.companion.pilots.choice import PilotChoice
    from flightstack.mavlink.motion import MotionHistory

PROGRAM = "flightstack.companion"
DEFAULT_PORT = "14540"  # PX4's port for companions
DEFAULT_MODEL = "strong/m0"
EPILOG = """connection strings: 14550, udpin:host:port, udpout:host:port, tcp:host:port,
/dev/ttyACM0,921600, and MAVSDK's udpin://host:port, udpout://host:port, tcpout://host:port,
serial:///dev/ttyACM0:57600.

exit codes: 0 done, 1 mission failed, 2 usage, 3 no vehicle, link or camera, 4 bad model,
130 interrupted. SIGINT and SIGTERM land first; a second one ends at once."""


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(
        prog=program,
        description="Fly a MAVLink vehicle through gates by what its camera sees.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--udp", metavar="PORT", help="listen on this UDP port (default 14540)")
    where.add_argument("--connect", metavar="STRING", help="connection string, see below")
    add("--system", type=_system, metavar="N", help="of the vehicle (first that has a camera)")
    add("--model", help=f"which model flies (default {DEFAULT_MODEL})")
    add("--strategy", help="how it decides (default: the model's); yours as my_package:MyStrategy")
    add("--perception", metavar="NAME", help="your own instead of the model's")
    add("--policy", metavar="NAME", help="your own instead of the model's")
    add("--pilot", metavar="NAME", help="your own instead of all three: from image to velocities")
    add("--pair-side", choices=("left", "right"), help="which of two gates (docs/belief.md)")
    add("--direction", choices=("cw", "ccw"), default="cw", help="of the course (default cw)")
    add("--seed", type=_whole, default=0, help="of the sampling (default 0)")
    add("--takeoff-altitude", type=_positive, default=3.0, metavar="M", help="m above home (3)")
    add("--duration", type=_positive, metavar="S", help="fly no longer than this, vehicle time")
    add("--gate-timeout", type=_positive, metavar="S", help="end so long after the last gate")
    add("--no-landing", action="store_true", help="end in the air: a simulation ends, too")
    add("--speed-scale", type=_positive, default=1.0, metavar="X", help="factor on commands (1)")
    add("--timeout", type=_positive, default=60.0, metavar="S", help="to find the vehicle (60)")
    add("--log", type=Path, metavar="PATH", help="tlog (default logs/companion-<UTC>.tlog)")
    add("--signing-key", type=Path, metavar="FILE", help="sign, and heed only what is signed")
    add("--record-frames", action="store_true", help="keep each frame as PNG, in LOG.frames")
    add("--check", action="store_true", help="do all but fly, and say what is missing")
    add("--json", action="store_true", help="last line of output: the result as JSON")
    add_camera_options(parser)
    _add_limits(parser)
    loudness = parser.add_mutually_exclusive_group()
    loudness.add_argument("-v", "--verbose", action="store_true", help="tell more")
    loudness.add_argument("-q", "--quiet", action="store_true", help="tell only the result")
    return parser


def _add_limits(parser: argparse.ArgumentParser) -> None:
    """Add the limits that hold whatever the pilot asks, and what else is there for safety."""
    parser.add_argument(
        "--reach", type=_positive, default=300.0, metavar="S", help="to call a lost vehicle (300)"
    )
    parser.add_argument(
        "--take-over", action="store_true", help="go on though armed, or steered by others"
    )
    parser.add_argument(
        "--part-memory", type=_positive, default=2.0, metavar="GB", help="of your own parts (2)"
    )
    add = parser.add_argument_group(
        "limits: outside, the vehicle is held, then landed"
    ).add_argument
    add("--min-height", type=_number, default=0.3, metavar="M", help="m above home (0.3)")
    add("--max-height", type=_positive, default=50.0, metavar="M", help="m above home (50)")
    add("--max-distance", type=_positive, default=300.0, metavar="M", help="from home (300)")
    add("--max-speed", type=_positive, default=12.0, metavar="M/S", help="horizontal (12)")
    add("--max-climb", type=_positive, default=5.0, metavar="M/S", help="upwards (5)")
    add("--max-descent", type=_positive, default=5.0, metavar="M/S", help="downwards (5)")


def main(argv: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run the companion; returns the exit code."""
    arguments = build_parser(program).parse_args(argv)
    return run_command(program, lambda: _fly(arguments))


def _fly(arguments: argparse.Namespace) -> int:
    # Here, not above: --help and a mistyped option must not wait for OpenCV and torch.
    from flightstack.companion.console import Console  # noqa: PLC0415
    from flightstack.companion.flight import fly  # noqa: PLC0415
    from flightstack.companion.signals import ending_at_once  # noqa: PLC0415

    plan, choice = _plan(arguments), _choice(arguments)

    def load_pilot(motion: "MotionHistory") -> "GuardedPilot":
        from flightstack.companion.pilots.choice import load_pilot as load  # noqa: PLC0415

        return load(choice, motion)

    console = Console(verbosity=int(arguments.verbose) - int(arguments.quiet))
    if arguments.check:
        return _check(plan, load_pilot, choice, console, as_json=arguments.json)
    with ending_at_once():
        summary = fly(plan, load_pilot, console)
    if arguments.json:
        model, strategy = choice.names
        print(summary.to_json(model=model, strategy=strategy), flush=True)
    else:
        print(summary.to_text(), flush=True)
    return summary.exit_code


def _check(
    plan: "FlightPlan",
    load_pilot: "Callable[[MotionHistory], GuardedPilot]",
    choice: "PilotChoice",
    console: "Console",
    *,
    as_json: bool,
) -> int:
    from flightstack.companion.readiness.check import check  # noqa: PLC0415
    from flightstack.companion.signals import ending_at_once  # noqa: PLC0415

    with ending_at_once():
        found = check(plan, load_pilot, choice.model or f"{choice.pilot}", console)
    print(found.to_json() if as_json else printable(found.to_text(), keep="\n"), flush=True)
    return 0 if found.is_ready else 1


def _choice(arguments: argparse.Namespace) -> "PilotChoice":
    from flightstack.companion.pilots.choice import PilotChoice  # noqa: PLC0415

    return PilotChoice(
        model=arguments.model or (DEFAULT_MODEL if arguments.pilot is None else None),
        strategy=arguments.strategy,
        perception=arguments.perception,
        policy=arguments.policy,
        pilot=arguments.pilot,
        pair_side=arguments.pair_side,
        direction=arguments.direction,
        seed=arguments.seed,
        part_memory_gb=arguments.part_memory,
    )


def _plan(arguments: argparse.Namespace) -> "FlightPlan":
    from flightstack.companion.opening.steps import FlightPlan  # noqa: PLC0415
    from flightstack.mavlink.endpoint import parse_endpoint  # noqa: PLC0415
    from flightstack.mavlink.signing import load_key  # noqa: PLC0415

    return FlightPlan(
        endpoint=parse_endpoint(arguments.connect or arguments.udp or DEFAULT_PORT),
        log=arguments.log or _default_log(),
        record_images=arguments.record_frames,
        camera=arguments.camera,
        camera_host=arguments.camera_host,
        camera_settings=camera_settings(arguments),
        takeoff_altitude_m=arguments.takeoff_altitude,
        duration_s=arguments.duration,
        gate_timeout_s=arguments.gate_timeout,
        lands=not arguments.no_landing,
        takes_over=arguments.take_over,
        reach_s=arguments.reach,
        limits=_limits(arguments),
        speed_scale=arguments.speed_scale,
        system=arguments.system,
        timeout_s=arguments.timeout,
        signing_key=None if arguments.signing_key is None else load_key(arguments.signing_key),
    )


def _limits(arguments: argparse.Namespace) -> "FlightLimits":
    from flightstack.companion.guards.limits import FlightLimits  # noqa: PLC0415

    if arguments.takeoff_altitude > arguments.max_height:
        raise UsageError(
            f"--takeoff-altitude {arguments.takeoff_altitude:g} lies above "
            f"--max-height {arguments.max_height:g}"
        )
    return FlightLimits(
        min_height_m=arguments.min_height,
        max_height_m=arguments.max_height,
        max_distance_m=arguments.max_distance,
        max_speed_m_s=arguments.max_speed,
        max_climb_m_s=arguments.max_climb,
        max_descent_m_s=arguments.max_descent,
    )


def _default_log() -> Path:
    return Path("logs", f"companion-{datetime.now(UTC):%Y%m%dT%H%M%S.%f}"[:-3] + "Z.tlog")


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text} is not a number")
    return value


def _positive(text: str) -> float:
    value = float(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a number above 0")
    return value


def _system(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 255:
        raise argparse.ArgumentTypeError(f"{text} is no MAVLink system: 1 to 255")
    return value


def _whole(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number from 0")
    return value
