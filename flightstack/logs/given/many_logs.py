"""Do the same for many logs on all cores, and give the results in the order of the logs."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import TypeVar

from flightstack.logs.checks import load_checks
from flightstack.logs.errors import LogFileError

Result = TypeVar("Result")
FEW = 8  # logs: starting processes takes longer than reading so few
LOGS_AT_ONCE = 4  # that a process takes


def _answer(work: Callable[[Path], Result], path: Path) -> Result | LogFileError:
    """Return what the work gives, or how it failed: a log that fails does not stop the others."""
    try:
        return work(path)
    except LogFileError as error:
        return LogFileError(str(error))  # without what hangs on it, to cross to another process


def _begin(checks: Path | None) -> None:
    if checks is not None:
        load_checks(checks)


def for_each(
    work: Callable[[Path], Result], paths: Sequence[Path], checks: Path | None
) -> Iterator[Result | LogFileError]:
    """Yield what the work gives for each log, in order, or its LogFileError.

    `work` must be picklable; the user's own checks are registered in every process.
    """
    processes = min(os.cpu_count() or 1, len(paths))
    if len(paths) < FEW or processes < 2:
        yield from (_answer(work, path) for path in paths)
        return
    with ProcessPoolExecutor(
        processes, mp_context=get_context("fork"), initializer=_begin, initargs=(checks,)
    ) as pool:
        yield from pool.map(partial(_answer, work), paths, chunksize=LOGS_AT_ONCE)
