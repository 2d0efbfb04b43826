"""Load matplotlib without a display, or say how to install it."""

import importlib
from types import ModuleType

from flightstack.logs.errors import MissingLibraryError


def load_pyplot() -> ModuleType:
    """Return matplotlib.pyplot drawing to files."""
    try:
        import matplotlib as mpl  # noqa: PLC0415
    except ImportError as error:
        raise MissingLibraryError("plots need matplotlib: pip install matplotlib") from error
    mpl.use("Agg")
    return importlib.import_module("matplotlib.pyplot")
