"""Load a library that only an extra of this package installs, or say how to install it."""

import importlib
from typing import Any

from flightstack.errors import UsageError


class MissingLibraryError(UsageError):
    """An optional library is not installed."""


def load_library(name: str, extra: str) -> Any:
    """Import a module of a library that `extra` installs; raises MissingLibraryError."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingLibraryError(
            f"this needs {name.partition('.')[0]}: pip install 'flightstack[{extra}]'"
        ) from error


def load_pyplot(extra: str) -> Any:
    """Import matplotlib.pyplot, drawing to files."""
    load_library("matplotlib", extra).use("Agg")
    return load_library("matplotlib.pyplot", extra)
