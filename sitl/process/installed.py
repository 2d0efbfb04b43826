"""Say how to install what a command of the simulator lacks: one line, for this installation."""

import sys
from importlib.util import find_spec
from pathlib import Path

from sitl.errors import UsageError

ROOT = Path(__file__).resolve().parents[2]  # of a checkout, where this is one
CONSTRAINTS = "constraints.txt"


def require(library: str, extra: str, purpose: str) -> None:
    """Raise UsageError where a library that an extra installs is missing."""
    if find_spec(library) is not None:
        return
    python = f"{sys.executable} -m pip install"
    if (ROOT / CONSTRAINTS).is_file():
        how = f"{python} --constraint {ROOT / CONSTRAINTS} --editable '{ROOT}[{extra}]'"
    else:
        how = f"{python} 'flightstack[{extra}] @ <the wheel's path or address>'"
    raise UsageError(f"{purpose} needs {library}: {how}")
