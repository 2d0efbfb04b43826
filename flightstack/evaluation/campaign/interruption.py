"""Stop at the first Ctrl-C or SIGTERM, and tidy up undisturbed by the next."""

import contextlib
import signal
from collections.abc import Iterator
from types import FrameType

EXIT_BY_SIGNAL = 128  # plus the signal's number, as shells say it


@contextlib.contextmanager
def interrupted_once() -> Iterator[None]:
    """Raise KeyboardInterrupt at SIGINT and SystemExit at SIGTERM, once.

    All further ones are ignored until the process ends, so that neither workers nor files of
    flights are left. For the main thread.
    """
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    has_stopped = False

    def stop(number: int, _: FrameType | None) -> None:
        nonlocal has_stopped
        has_stopped = True
        for each in before:
            signal.signal(each, signal.SIG_IGN)
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        raise SystemExit(EXIT_BY_SIGNAL + number)

    for number in before:
        signal.signal(number, stop)
    try:
        yield
    finally:
        if not has_stopped:
            for number, handler in before.items():
                signal.signal(number, handler)


@contextlib.contextmanager
def ignoring_interrupts() -> Iterator[None]:
    """Ignore SIGINT for a moment: processes that are started inside ignore it for good."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
