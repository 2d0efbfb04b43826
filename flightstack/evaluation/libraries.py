"""Load a library of the extra `evaluation`, or say how to install it."""

import importlib
from typing import Any

from flightstack.errors import UsageError


class MissingLibraryError(UsageError):
    """An optional library is not installed."""


def load_library(name: str) -> Any:
    """Import an optional module; raises MissingLibraryError."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingLibraryError(
            f"this needs {name.partition('.')[0]}: pip install 'flightstack[evaluation]'"
        ) from error


def load_pyplot() -> Any:
    """Import matplotlib.pyplot, drawing to files."""
    load_library("matplotlib").use("Agg")
    return load_library("matplotlib.pyplot")
