"""argparse, with errors of one line, and options that are named in full."""

import argparse
from typing import Any, NoReturn

USAGE = 2  # exit code


class OptionParser(argparse.ArgumentParser):
    """The parser of every command of flightstack; its sub-commands are of this kind, too."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(allow_abbrev=False, **settings)  # a new option would break shortened ones

    def error(self, message: str) -> NoReturn:
        """Say in one line what is wrong, and where all options stand."""
        self.exit(USAGE, f"{self.prog}: {message}; --help lists the options\n")
