"""The sub-commands of `flightstack`: one row each."""

import argparse
import importlib
from types import ModuleType
from typing import NamedTuple

PROGRAM = "flightstack"


class SubCommand(NamedTuple):
    """One of them. Its module has `build_parser(program)` and `main(arguments, program)`."""

    about: str
    module: str  # by name: what is not asked for is not imported, nor need it be installed

    def load(self) -> ModuleType:
        """Import its module, which itself says what it lacks."""
        return importlib.import_module(self.module)


COMMANDS = {
    "fly": SubCommand(
        "fly one course in simulation, and say what happened", "flightstack.launch.cli"
    ),
    "sitl": SubCommand("a simulated PX4-style quadrotor with a camera", "sitl.process.cli"),
    "companion": SubCommand(
        "fly a MAVLink vehicle by what its camera sees", "flightstack.companion.cli"
    ),
    "logs": SubCommand("inspect MAVLink logs, and the vehicle's own", "flightstack.logs.cli"),
    "live": SubCommand("a flight in a browser, while it is flown or later", "flightstack.live.cli"),
    "camera": SubCommand(
        "get to know a camera: its lens, its latency", "flightstack.calibration.cli"
    ),
    "train": SubCommand("make data, train, write models", "flightstack.training.commands.cli"),
    "evaluate": SubCommand("judge models, and policies of yours", "flightstack.evaluation.cli"),
    "completion": SubCommand(
        "completion of this command, for a shell", "flightstack.cli.completion"
    ),
}


def program_of(name: str) -> str:
    """Return what a sub-command is called in its help and its errors."""
    return f"{PROGRAM} {name}"


def parser_of(name: str) -> argparse.ArgumentParser:
    """Return the parser of a sub-command, anew each time."""
    parser: argparse.ArgumentParser = COMMANDS[name].load().build_parser(program_of(name))
    return parser
