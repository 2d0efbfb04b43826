"""Pilots that go wrong from their third image on, each in a way of its own."""

import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from flightstack.companion.piloting.failure import POLICY, PartMarker
from flightstack.records import ALL_MEMBERS, Decision, Image

GOOD_IMAGES = 2
FORWARD_M_S = 2.0
Answer = Callable[[Decision], Any]


def good_decision() -> Decision:
    """Straight on."""
    command = np.array([FORWARD_M_S, 0.0, 0.0, 0.0])
    spread = np.full(4, 0.1)
    return Decision(
        command=command,
        aleatoric_std=spread,
        epistemic_std=spread,
        perceptual_std=spread,
        score=np.zeros((5, 4)),
        member=np.full(4, ALL_MEMBERS),
        modes=np.ones(4, np.int64),
        member_mean=np.tile(command, (5, 1)),
    )


def raises(_: Decision) -> Any:
    raise ZeroDivisionError("on purpose\nand more")


def exits(_: Decision) -> Any:
    sys.exit()


def ends(_: Decision) -> Any:
    os._exit(0)


def dies(_: Decision) -> Any:
    os.kill(os.getpid(), signal.SIGSEGV)


def hangs(_: Decision) -> Any:
    time.sleep(1000.0)


def leaks(_: Decision) -> Any:
    held = []
    while True:
        held.append(np.ones(2_000_000))


def has_nan(decision: Decision) -> Any:
    return replace(decision, command=np.array([np.nan, 0.0, 0.0, 0.0]))


def is_infinite(decision: Decision) -> Any:
    return replace(decision, score=np.full((5, 4), np.inf))


def is_short(decision: Decision) -> Any:
    return _spoilt(decision, "command", np.zeros(3))


def is_nothing(_: Decision) -> Any:
    return None


def is_text(decision: Decision) -> Any:
    return _spoilt(decision, "modes", np.array(["a", "b", "c", "d"]))


def is_slow(decision: Decision) -> Any:
    time.sleep(0.3)
    return decision


class TurningPilot:
    """Flies straight on for a while, then does what it was made for, for `bad_images`."""

    def __init__(self, answer: Answer, marker: PartMarker, *, bad_images: int = 1 << 30) -> None:
        self._answer, self._marker, self._bad_images = answer, marker, bad_images
        self._seen = 0

    def decide(self, image: Image) -> Decision:  # noqa: ARG002  (flies blind)
        self._marker.mark(POLICY)
        self._seen += 1
        good = not GOOD_IMAGES < self._seen <= GOOD_IMAGES + self._bad_images
        decision: Decision = good_decision() if good else self._answer(good_decision())
        return decision


class Turning:
    """Loads such pilots: the one that is tried is a good one."""

    def __init__(self, answer: Answer, *, bad_images: int = 1 << 30) -> None:
        self._answer, self._bad_images = answer, bad_images
        self._made = 0

    def __call__(self, marker: PartMarker) -> Callable[[], TurningPilot]:
        def make() -> TurningPilot:
            self._made += 1
            answer = _good if self._made == 1 else self._answer
            return TurningPilot(answer, marker, bad_images=self._bad_images)

        return make


def _spoilt(decision: Decision, name: str, value: object) -> Decision:
    """Put in what the tests' own check of shapes would not let pass."""
    object.__setattr__(decision, name, value)
    return decision


def _good(decision: Decision) -> Decision:
    return decision
