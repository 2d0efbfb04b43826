"""Get to know a camera: its lens, what the networks see of it, how late it is."""

import argparse
import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from flightstack.arguments.ending import run_command
from flightstack.arguments.parser import OptionParser

PROGRAM = "python -m flightstack.calibration"


def _add_chessboard(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("recording", type=Path, help="video, or folder of images (LOG.frames), of a chessboard")
    add("--columns", type=int, default=9, metavar="N", help="inner corners in a row (9)")
    add("--rows", type=int, default=6, metavar="N", help="inner corners in a column (6)")
    add("--lens", choices=("plumb_bob", "rational_polynomial", "equidistant"), default="plumb_bob")
    add("-o", "--output", type=Path, default=Path("camera.yaml"), help="default camera.yaml")


def _add_view(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("recording", type=Path, help="image, video, or folder of images; its first image is shown")
    add("--camera-info", type=Path, metavar="FILE", help="calibration; left out: the middle square")
    add("-o", "--output", type=Path, default=Path("view.png"), help="default view.png")


def _add_latency(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("log", type=Path, help="tlog of a companion with --record-frames, turned by hand")
    add("--frames", type=Path, metavar="FOLDER", help="its frames; default LOG.frames")
    add("--json", action="store_true", help="for programs")


class CalibrationCommand(NamedTuple):
    """What the command line says of a command; its code is the module of that name."""

    about: str
    add_options: Callable[[argparse.ArgumentParser], None]


COMMANDS = {
    "chessboard": CalibrationCommand(
        "make a --camera-info file from a recording of a chessboard", _add_chessboard
    ),
    "view": CalibrationCommand("draw what the networks see, beside the whole image", _add_view),
    "latency": CalibrationCommand(
        "measure --camera-latency-s from a recording in which the vehicle was turned by hand",
        _add_latency,
    ),
}


def main(arguments: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run one command; returns the exit code."""
    options = build_parser(program).parse_args(arguments)

    def run() -> None:
        module = f"flightstack.calibration.commands.{options.command}"  # loads OpenCV
        print(importlib.import_module(module).run(options))

    return run_command(program, run)


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(prog=program, description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        command.add_options(
            commands.add_parser(name, help=command.about, description=command.about)
        )
    return parser
