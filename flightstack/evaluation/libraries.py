"""Load a library of the extra `evaluation`, or say how to install it."""

import importlib
from typing import Any

from flightstack.errors import UsageError


def load_library(name: str) -> Any:
    """Import an optional module; raises UsageError where it is missing."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise UsageError(
            f"this needs {name.partition('.')[0]}: pip install 'flightstack[evaluation]'"
        ) from error


def load_pyplot() -> Any:
    """Import matplotlib.pyplot, drawing to files."""
    load_library("matplotlib").use("Agg")
    return load_library("matplotlib.pyplot")
