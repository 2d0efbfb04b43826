"""Give what a user brings a name by which another process finds it."""

import pickle
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from flightstack.errors import UsageError
from flightstack.extensions import PICKLED
from flightstack.libraries import load_library

Brought = str | Callable[..., Any]  # the name of a factory, or the factory
SCRIPT = "__main__"  # another one in every process


def names_of(brought: Mapping[str, Brought | None], folder: Path) -> dict[str, str]:
    """Return the name of each part that is brought; raises as `name_of` does."""
    return {
        option: name_of(part, folder / option)
        for option, part in brought.items()
        if part is not None
    }


def name_of(part: Brought, path: Path) -> str:
    """Return the name of a factory; one without a name is written to `path`.pickle.

    Raises UsageError, in one line, where it cannot be written.
    """
    if isinstance(part, str):
        return part
    if not callable(part):
        raise UsageError(f"{path.name}: expected a factory or its name, got {part!r}")
    module, name = getattr(part, "__module__", SCRIPT), getattr(part, "__qualname__", "")
    if module != SCRIPT and getattr(sys.modules.get(module), name, None) is part:
        return f"{module}:{name}"
    file = path.with_suffix(PICKLED)
    try:
        file.write_bytes(_pickled(part))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise UsageError(
            f"{path.name}: {part!r} cannot be pickled ({error}); put it into a module of its own"
        ) from error
    return str(file)


def _pickled(part: Callable[..., Any]) -> bytes:
    """Pickle, functions and classes of scripts and notebooks by their code."""
    cloudpickle = load_library("cloudpickle", "gym")
    data: bytes = cloudpickle.dumps(part)
    return data
