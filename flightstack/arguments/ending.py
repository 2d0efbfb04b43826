"""How a command ends: with an exit code, and in one line where it could not do what it should."""

import sys
from collections.abc import Callable

from flightstack.errors import FlightstackError
from flightstack.printable import printable

EXIT_INTERRUPTED = 130


def run_command(
    program: str, command: Callable[[], int | None], *, interrupted: str = "interrupted"
) -> int:
    """Run a command, and return its exit code; None stands for 0.

    An error of ours becomes one line on standard error, and so does Ctrl-C, in the words of
    `interrupted`.
    """
    try:
        return command() or 0
    except FlightstackError as error:
        print(f"{program}: {printable(str(error))}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print(f"{program}: {interrupted}", file=sys.stderr)
        return EXIT_INTERRUPTED
