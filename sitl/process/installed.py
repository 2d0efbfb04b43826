"""Say how to install what a command of the simulator lacks: one line, for this installation."""

import json
import sys
from importlib.metadata import PackageNotFoundError, distribution
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
        how = f"{python} 'flightstack[{extra}] @ {_origin()}'"
    raise UsageError(f"{purpose} needs {library}: {how}")


def _origin() -> str:
    """Return what this package was installed from, as pip recorded it."""
    try:
        recorded = distribution("flightstack").read_text("direct_url.json")
        return str(json.loads(recorded or "")["url"])
    except (PackageNotFoundError, ValueError, KeyError):
        return "<the wheel's path or address>"
