"""Judge models, and draw what they say. Each command is a file in `commands/`."""

import argparse
import importlib
import os
from collections.abc import Sequence
from types import ModuleType

from flightstack.arguments.ending import run_command
from flightstack.arguments.options import sub_parsers
from flightstack.arguments.parser import OptionParser
from flightstack.libraries import require

PROGRAM = "python -m flightstack.evaluation"
COMMANDS = ("ablation", "benchmark", "figures", "ladder", "offline", "table")
LIBRARIES = ("pybullet", "joblib", "scipy", "matplotlib")


def main(arguments: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run one command; returns the exit code."""
    options = _parse(arguments, program)
    os.environ.setdefault("OMP_NUM_THREADS", "1")

    def run() -> None:
        require("evaluation", *LIBRARIES)
        _module(options.command).run(options)

    return run_command(program, run)


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(prog=program, description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in COMMANDS:
        module = _module(name)
        about = (module.__doc__ or "").splitlines()[0]
        module.add_arguments(commands.add_parser(name, help=about, description=about))
    return parser


def _parse(arguments: Sequence[str] | None, program: str) -> argparse.Namespace:
    """Parse; `given` names the options that the user gave, whatever their defaults are."""
    parser = build_parser(program)
    options = parser.parse_args(arguments)
    sub_parsers(parser)[options.command].set_defaults(**dict.fromkeys(vars(options)))
    again = vars(parser.parse_args(arguments))
    options.given = frozenset(name for name, value in again.items() if value is not None)
    return options


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"flightstack.evaluation.commands.{name}")
