"""Strategies that fly well until a file appears, and then go wrong, each in a way of its own."""

import os
import signal
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from flightstack.decision.strategies import make_strategy
from flightstack.records import ActionSamples, Decision

TRIGGER = "FLIGHTSTACK_FAULT"  # names the file
LEAK_FLOATS = 25_000_000 // 8  # 25 MB an image
SLOW_S = 0.3


class _Turning:
    """The mean, until the file is there."""

    def __init__(self, *, direction: str, seed: int) -> None:
        self._mean = make_strategy("de-mean", direction=direction, seed=seed)
        self._trigger = Path(os.environ[TRIGGER])
        self.held: list[object] = []

    def decide(self, samples: ActionSamples) -> Decision:
        """Decide one command."""
        decision = self._mean.decide(samples)
        return self.spoil(decision) if self._trigger.exists() else decision

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        raise NotImplementedError


class Raises(_Turning):
    """An exception at each image."""

    def spoil(self, decision: Decision) -> Decision:  # noqa: ARG002
        """Go wrong."""
        raise ZeroDivisionError("on purpose")


class RaisesOnce(_Turning):
    """An exception at one image."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        if not self.held:
            self.held.append(None)
            raise ZeroDivisionError("on purpose")
        return decision


class Exits(_Turning):
    """The end of the program, with exit code 0."""

    def spoil(self, decision: Decision) -> Decision:  # noqa: ARG002
        """Go wrong."""
        sys.exit()


class Dies(_Turning):
    """A crash of a library."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        os.kill(os.getpid(), signal.SIGSEGV)
        return decision


class Hangs(_Turning):
    """A wait without end."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        time.sleep(1e6)
        return decision


class Leaks(_Turning):
    """Memory that is never given back."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        self.held.append(np.ones(LEAK_FLOATS))
        return decision


class IsSlow(_Turning):
    """Three decisions a second."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        time.sleep(SLOW_S)
        return decision


class GivesNan(_Turning):
    """A command that is no number."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        return replace(decision, command=decision.command * np.nan)


class GivesThree(_Turning):
    """A command of three velocities."""

    def spoil(self, decision: Decision) -> Decision:
        """Go wrong."""
        return replace(decision, command=decision.command[:3])
