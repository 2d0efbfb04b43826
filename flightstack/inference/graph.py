"""Run networks in their flight form: graphs in ONNX, on one thread of ONNX Runtime.

A graph is a pure function of its inputs: all chance comes in from outside. On the same machine and
build its outputs are the same to the last bit, whatever runs beside it. A graph's file is data that
anybody may have made: it is read as far as a limit, known by its hash, and refused where its
inputs or outputs are not those that the configuration beside it leads to.
"""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.errors import ModelError
from flightstack.inference.contents import complaint

# Its builds since 1.29 report to their maker how they are used, on Linux, too, and keep a file for
# that in the folder for temporary files. They read this when they are loaded. Nothing here reports.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
import onnxruntime

onnxruntime.disable_telemetry_events()

MAX_BYTES = 1 << 28
FATAL = 4  # of ONNX Runtime's levels of severity: what it has to say comes as an exception
PROVIDERS = ("CPUExecutionProvider",)
TYPES = {"tensor(float)": np.float32, "tensor(uint8)": np.uint8}

Shape = tuple[int | None, ...]  # None: as many as a call brings
Ports = Mapping[str, Shape]


@dataclass(frozen=True, slots=True, kw_only=True)
class Signature:
    """What goes into a graph and comes out of it: names and shapes."""

    inputs: Ports
    outputs: Ports


class Graph:
    """A network, loaded and checked, ready to run."""

    def __init__(self, path: Path, *, sha256: str, signature: Signature) -> None:
        """Read a file; raises ModelError where it cannot be read, is damaged, or does not fit."""
        content = _read(path)
        if hashlib.sha256(content).hexdigest() != sha256:
            raise ModelError(f"{path} is damaged: its hash is not what config.toml records")
        wrong = complaint(content)
        if wrong is not None:
            raise ModelError(f"{path} is refused: {wrong}")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = FATAL
        try:
            self._session = onnxruntime.InferenceSession(content, options, providers=PROVIDERS)
        except Exception as error:  # its errors have no base of their own
            raise ModelError(f"{path} cannot be read: {_first_line(error)}") from error
        _check(path, "input", self._session.get_inputs(), signature.inputs)
        _check(path, "output", self._session.get_outputs(), signature.outputs)
        self._run = self._session.run

    def run(self, outputs: list[str], inputs: dict[str, NDArray[Any]]) -> list[NDArray[np.float32]]:
        """Compute outputs, by name, from all inputs; raises ValueError for what does not fit."""
        try:
            found: list[NDArray[np.float32]] = self._run(outputs, inputs)
        except Exception as error:  # its errors have no base of their own
            raise ValueError(_first_line(error)) from error
        return found


def _read(path: Path) -> bytes:
    if not path.is_file():
        raise ModelError(f"{path} cannot be read: there is no such file")
    with path.open("rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise ModelError(f"{path} is larger than {MAX_BYTES} bytes: no network that flies here is")
    return content


def _check(path: Path, side: str, found: list[Any], wanted: Ports) -> None:
    """Compare a graph's inputs or outputs with what is wanted of them."""
    names = [port.name for port in found]
    if sorted(names) != sorted(wanted):
        raise _misfit(path, f"its {side}s are {', '.join(names)}, not {', '.join(wanted)}")
    for port in found:
        if port.type not in TYPES:
            raise _misfit(path, f"{port.name} is a {port.type}")
        needed = wanted[port.name]
        if not _fits(port.shape, needed):
            shape = tuple(size if isinstance(size, int) else None for size in port.shape)
            raise _misfit(path, f"{port.name} is {_text(shape)}, not {_text(needed)}")


def _fits(shape: list[int | str | None], needed: Shape) -> bool:
    """Hold shapes against each other: a size left open fits one that each call may choose alone."""
    return len(shape) == len(needed) and all(
        not isinstance(size, int) if wanted is None else size == wanted
        for size, wanted in zip(shape, needed, strict=True)
    )


def _text(shape: Shape) -> str:
    return "(" + ", ".join("any" if size is None else str(size) for size in shape) + ")"


def _misfit(path: Path, what: str) -> ModelError:
    return ModelError(f"{path.parent}: {path.name} does not fit config.toml: {what}")


def _first_line(error: Exception) -> str:
    return str(error).partition("\n")[0]
