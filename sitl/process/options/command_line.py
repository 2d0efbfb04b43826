"""What the user asks for: the command line over PX4's environment variables over defaults."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn, TypeVar

from sitl.errors import UsageError
from sitl.frames import HOME
from sitl.process.options import values
from sitl.process.options.external_options import ExternalOptions, read_external
from sitl.process.options.px4_options import EXTERNAL, Px4Options, add_px4, read_px4
from sitl.process.options.values import Address
from sitl.records.conditions import Conditions, read_conditions
from sitl.records.course import Direction
from sitl.records.motion import Vector3

PROGRAM = "sitl"
NOISE = (1.0, 2.0)  # GRN, GHN
GCS_PORTS = (18570, 14550)  # local, remote, as PX4; the local one grows with the instance
API_PORTS = (14580, 14540)  # both grow with the instance
API_REMOTE_LAST = 14549  # PX4 stops there
CAMERA_PORT = 8090
PARAMETER_PREFIX = "PX4_PARAM_"
READY_S = 4.0  # 3.6 to 4.8 s were seen of PX4 v1.17.0; in lockstep they would only be computed

T = TypeVar("T")


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """One vehicle, as asked for."""

    seed: int
    track_seed: int
    noise_m: tuple[float, float]  # GRN, GHN
    direction: Direction
    laps: int
    speed_factor: float  # 0: as fast as possible
    lockstep: bool
    gui: bool
    perfect_estimate: bool
    ready_after_s: float  # vehicle time, until it can be armed
    conditions: Conditions
    instance: int
    home: Vector3
    has_home: bool  # it was asked for
    log: Path | None
    signing_key: Path | None
    files: Path | None
    params: Path | None
    gcs_ports: tuple[int, int]  # local, remote
    api_ports: tuple[int, int]
    udp: Sequence[Address]  # of further links, which go out to there
    tcp: Sequence[Address]  # where further links wait for a client
    camera_port: int
    video: Address | None
    verbosity: int  # -1 quiet, 0, 1 verbose
    parameters: Mapping[str, str]  # PX4_PARAM_<NAME>
    px4: Px4Options | None  # None: another flies
    external: ExternalOptions | None
    prints_px4_environment: bool

    @property
    def system(self) -> int:
        """MAVLink system id."""
        return self.instance + 1


class _UsageParser(argparse.ArgumentParser):
    """Errors are one line that says what to do."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message}; --help lists the options")


def parse(argv: Sequence[str], environment: Mapping[str, str], program: str = PROGRAM) -> Options:
    """Read the command line and the environment.

    Raises:
        UsageError: something cannot be; says what, which value, and what would be.

    """
    given = build_parser(program).parse_args(argv)
    instance = given.instance
    conditions = read_conditions(given.conditions, given.condition)
    home = given.home or _home_from(environment)
    return Options(
        seed=given.seed,
        track_seed=given.track_seed,
        noise_m=given.noise,
        direction=given.direction,
        laps=given.laps,
        speed_factor=_first(given.speed_factor, _speed_from(environment), 1.0),
        lockstep=given.lockstep,
        gui=given.gui,
        perfect_estimate=given.perfect_estimate,
        ready_after_s=_first(
            given.ready_after, None, values.MIN_READY_S if given.lockstep else READY_S
        ),
        conditions=conditions,
        instance=instance,
        home=home or HOME,
        has_home=home is not None,
        log=given.log,
        signing_key=given.signing_key,
        files=given.files,
        params=given.params,
        gcs_ports=given.gcs_link or (GCS_PORTS[0] + instance, GCS_PORTS[1]),
        api_ports=given.api_link
        or (API_PORTS[0] + instance, min(API_PORTS[1] + instance, API_REMOTE_LAST)),
        udp=tuple(given.udp),
        tcp=tuple(given.tcp),
        camera_port=_first(given.camera_port, None, CAMERA_PORT + instance),
        video=given.video,
        verbosity=given.verbose - given.quiet,
        parameters=_parameters_from(environment),
        px4=read_px4(given),
        external=read_external(given, conditions) if given.autopilot == EXTERNAL else None,
        prints_px4_environment=given.px4_environment,
    )


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = _UsageParser(
        prog=program,
        description="A simulated PX4-style quadrotor with a camera, on a course of gates.",
        epilog="PX4_SIM_SPEED_FACTOR, PX4_HOME_LAT, PX4_HOME_LON, PX4_HOME_ALT and "
        "PX4_PARAM_<NAME> are heeded, as by PX4; the command line goes before them.",
        allow_abbrev=False,
    )
    _add_world(parser)
    _add_conditions(parser)
    _add_time(parser)
    _add_connections(parser)
    add_px4(parser)
    return parser


def _add_world(parser: argparse.ArgumentParser) -> None:
    world = parser.add_argument_group("world")
    world.add_argument(
        "--seed", type=values.seed, default=0, metavar="N", help="of light, colours and sensors"
    )
    world.add_argument(
        "--track-seed", type=values.seed, default=0, metavar="N", help="of the gates' places"
    )
    world.add_argument(
        "--noise",
        type=values.noise,
        default=NOISE,
        metavar="GRN,GHN",
        help="m, of the gates' radius and height (default 1.0,2.0)",
    )
    world.add_argument("--direction", choices=("cw", "ccw"), default="cw", help="seen from above")
    world.add_argument(
        "--laps", type=values.laps, default=1, metavar="N", help="rounds of the course (default 1)"
    )
    world.add_argument(
        "--home",
        type=values.home,
        metavar="LAT,LON,ALT",
        help="deg, deg, m AMSL of the spawn point",
    )
    world.add_argument("--gui", action="store_true", help="show the world in a window")
    world.add_argument(
        "--perfect-estimate", action="store_true", help="let the autopilot know the true state"
    )


def _add_conditions(parser: argparse.ArgumentParser) -> None:
    conditions = parser.add_argument_group(
        "conditions", "wind, fog, darkness, camera faults, second gates: see docs/conditions.md"
    )
    conditions.add_argument(
        "--conditions",
        type=Path,
        metavar="FILE",
        help="a TOML file of them",
    )
    conditions.add_argument(
        "--condition",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="one of them, as camera.latency_s=0.1; goes before the file",
    )


def _add_time(parser: argparse.ArgumentParser) -> None:
    running = parser.add_argument_group("time")
    running.add_argument(
        "--speed-factor",
        type=values.speed,
        metavar="X",
        help="1: real time; 0: as fast as possible",
    )
    running.add_argument(
        "--lockstep", action="store_true", help="wait for an answer to each camera image"
    )
    running.add_argument(
        "--ready-after",
        type=values.ready,
        metavar="S",
        help="vehicle time until it can be armed (default 4, as PX4; in lockstep 1)",
    )


def _add_connections(parser: argparse.ArgumentParser) -> None:
    wire = parser.add_argument_group("wire")
    wire.add_argument(
        "--instance", type=values.instance, default=0, metavar="N", help="vehicle N + 1, own ports"
    )
    for name, whom in (("--gcs-link", "the ground station"), ("--api-link", "an offboard program")):
        wire.add_argument(
            name, type=values.ports, metavar="LOCAL:REMOTE", help=f"UDP ports of the link to {whom}"
        )
    for name, metavar, text, read in (
        ("--udp", "HOST:PORT", "a further link, out to there", values.address),
        ("--tcp", "[HOST:]PORT", "a further link, for one client", values.listening_address),
    ):
        wire.add_argument(name, action="append", default=[], type=read, metavar=metavar, help=text)
    wire.add_argument(
        "--camera-port", type=values.port, metavar="P", help="HTTP port of the camera"
    )
    wire.add_argument(
        "--video", type=values.video_address, metavar="udp://HOST:PORT", help="send RTP H.264 there"
    )
    wire.add_argument(
        "--signing-key", type=Path, metavar="FILE", help="heed only what is signed with this key"
    )
    wire.add_argument(
        "--files", type=Path, metavar="DIR", help="folder of flight logs that may be fetched"
    )
    wire.add_argument(
        "--params", type=Path, metavar="FILE", help="keep changed parameters, from run to run"
    )
    wire.add_argument("--log", type=Path, metavar="PATH", help="write all traffic as a tlog")
    wire.add_argument("-v", "--verbose", action="count", default=0, help="say more")
    wire.add_argument("-q", "--quiet", action="count", default=0, help="say only what is wrong")


def _first(given: T | None, inherited: T | None, default: T) -> T:
    if given is not None:
        return given
    return default if inherited is None else inherited


def _parameters_from(environment: Mapping[str, str]) -> dict[str, str]:
    return {
        name.removeprefix(PARAMETER_PREFIX): value
        for name, value in environment.items()
        if name.startswith(PARAMETER_PREFIX)
    }


def _speed_from(environment: Mapping[str, str]) -> float | None:
    return _from_environment(environment, "PX4_SIM_SPEED_FACTOR", values.speed)


def _home_from(environment: Mapping[str, str]) -> Vector3 | None:
    names = ("PX4_HOME_LAT", "PX4_HOME_LON", "PX4_HOME_ALT")
    if not any(name in environment for name in names):
        return None
    texts = [
        environment.get(name, str(fallback)) for name, fallback in zip(names, HOME, strict=True)
    ]
    return _from_environment({"PX4_HOME_*": ",".join(texts)}, "PX4_HOME_*", values.home)


def _from_environment(
    environment: Mapping[str, str], name: str, read: Callable[[str], T]
) -> T | None:
    if name not in environment:
        return None
    try:
        return read(environment[name])
    except (argparse.ArgumentTypeError, ValueError) as error:
        raise UsageError(f"{name}: {error}") from None
