"""Judge models, and draw what they say. Each command is a file in `commands/`."""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from types import ModuleType

from flightstack.errors import FlightstackError

PROGRAM = "python -m flightstack.evaluation"
COMMANDS = ("ablation", "benchmark", "figures", "ladder", "offline", "table")
EXIT_INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    modules = {name: _module(name) for name in COMMANDS}
    options = _parser(modules).parse_args(arguments)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    try:
        modules[options.command].run(options)
    except FlightstackError as error:
        print(f"{PROGRAM}: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    return 0


def _parser(modules: dict[str, ModuleType]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=PROGRAM, description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, module in modules.items():
        about = (module.__doc__ or "").splitlines()[0]
        module.add_arguments(commands.add_parser(name, help=about, description=about))
    return parser


def _module(name: str) -> ModuleType:
    return importlib.import_module(f"flightstack.evaluation.commands.{name}")
