"""`python -m sitl`: read what the user asks for, then start the vehicle."""

import argparse
import logging
import os
import sys
from collections.abc import Sequence

from sitl.errors import INTERRUPTED, SitlError
from sitl.process.installed import require

PROGRAM = "sitl"
LEVELS = {-1: logging.ERROR, 0: logging.INFO, 1: logging.DEBUG}


def main(argv: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run the command until a signal; returns its exit code."""
    try:
        from sitl.process.options.command_line import parse  # noqa: PLC0415  so that a signal now ends it quietly

        options = parse(sys.argv[1:] if argv is None else argv, os.environ, program)
        level = LEVELS[max(-1, min(1, options.verbosity))]
        logging.basicConfig(level=level, format="sitl: %(message)s", stream=sys.stderr)
        require("pybullet", "sim", "the simulator")
        from sitl.process.launch import launch  # noqa: PLC0415  --help and bad options need no MAVLink

        return launch(options)
    except KeyboardInterrupt:  # before it runs
        sys.stderr.write(f"{program}: interrupted\n")
        return INTERRUPTED
    except SitlError as error:
        sys.stderr.write(f"{program}: {error}\n")
        return error.exit_code


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    from sitl.process.options.command_line import build_parser as build  # noqa: PLC0415  likewise

    return build(program)
