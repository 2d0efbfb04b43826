"""Load a library that only an extra of this package installs, or say how to install it here."""

import importlib
import json
import sys
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from flightstack.errors import UsageError

ROOT = Path(__file__).resolve().parent.parent  # of a checkout, where this is one
CONSTRAINTS = "constraints.txt"


class MissingLibraryError(UsageError):
    """An optional library is not installed."""


def load_library(name: str, extra: str) -> Any:
    """Import a module of a library that `extra` installs; raises MissingLibraryError."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise _missing(name, extra) from error


def require(extra: str, *libraries: str) -> None:
    """Raise MissingLibraryError where one of the libraries that `extra` installs is missing."""
    for name in libraries:
        if find_spec(name) is None:
            raise _missing(name, extra)


def load_pyplot(extra: str) -> Any:
    """Import matplotlib.pyplot, drawing to files."""
    load_library("matplotlib", extra).use("Agg")
    return load_library("matplotlib.pyplot", extra)


def install_command(extra: str) -> str:
    """Return the command that adds an extra to this installation, of a checkout or a wheel."""
    python = f"{sys.executable} -m pip install"
    if (ROOT / CONSTRAINTS).is_file():
        return f"{python} --constraint {ROOT / CONSTRAINTS} --editable '{ROOT}[{extra}]'"
    return f"{python} 'flightstack[{extra}] @ {_origin()}'"


def _missing(name: str, extra: str) -> MissingLibraryError:
    library = name.partition(".")[0]
    return MissingLibraryError(f"this needs {library}: {install_command(extra)}")


def _origin() -> str:
    """Return what this package was installed from, as pip recorded it."""
    try:
        recorded = distribution("flightstack").read_text("direct_url.json")
        return str(json.loads(recorded or "")["url"])
    except (PackageNotFoundError, ValueError, KeyError):
        return "<the wheel's path or address>"
