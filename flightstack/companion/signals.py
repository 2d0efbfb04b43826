"""SIGINT and SIGTERM: before the flight they end at once; in flight the first one lands."""

import contextlib
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from types import FrameType


@dataclass(slots=True)
class StopSwitch:
    """Asks the loop to land and end."""

    requested: bool = False


@contextlib.contextmanager
def ending_at_once() -> Iterator[None]:
    """Raise KeyboardInterrupt for SIGTERM too."""
    previous = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


@contextlib.contextmanager
def landing_first(stop: StopSwitch) -> Iterator[None]:
    """Flip the switch at the first signal; raise KeyboardInterrupt at the second."""

    def handle(signum: int, frame: FrameType | None) -> None:
        if stop.requested:
            _interrupt(signum, frame)
        stop.requested = True

    previous = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def _interrupt(_signum: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
