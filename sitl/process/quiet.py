"""Keep a C library from writing to standard output and standard error."""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager

OUTPUTS = (1, 2)  # file descriptors


@contextmanager
def quiet_outputs() -> Iterator[None]:
    """Drop what is printed meanwhile, as pybullet does when it is imported; exceptions pass."""
    flush = ctypes.CDLL(None).fflush
    flush(None)
    kept = [os.dup(output) for output in OUTPUTS]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for output in OUTPUTS:
            os.dup2(nowhere, output)
        yield
    finally:
        flush(None)
        for output, copy in zip(OUTPUTS, kept, strict=True):
            os.dup2(copy, output)
            os.close(copy)
        os.close(nowhere)
