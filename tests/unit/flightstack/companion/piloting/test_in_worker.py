"""A worker process that raises, hangs, leaks or dies: what its parent says of each."""

import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from flightstack.companion.piloting.failure import PartFailure, PartMarker
from flightstack.companion.piloting.in_process import InProcessPilot
from flightstack.companion.piloting.in_worker import WorkerPilot, memory_bytes
from flightstack.companion.piloting.protocols import PilotMaker
from flightstack.companion.waiting import Readable, wait_for_any
from flightstack.errors import FlightstackError, ModelError, UsageError
from flightstack.records import Decision, Image
from tests.unit.flightstack.companion.piloting import bad_pilots
from tests.unit.flightstack.companion.piloting.bad_pilots import Answer, Turning, good_decision

RGB = np.zeros((64, 64, 3), np.uint8)
ROOM_BYTES = 300e6  # above what this process holds
GOES_WRONG = {
    bad_pilots.raises: "policy raised ZeroDivisionError: on purpose",
    bad_pilots.exits: "policy raised SystemExit",
    bad_pilots.has_nan: "policy gave command that is not finite",
    bad_pilots.is_infinite: "policy gave score that is not finite",
    bad_pilots.is_short: "policy gave command of shape (3,), not (4,)",
    bad_pilots.is_nothing: "policy gave NoneType, not a Decision",
    bad_pilots.is_text: "policy gave modes as an array of <U1, not as an array of numbers",
}
ENDS = {
    bad_pilots.ends: "policy has ended its process with exit code 0",
    bad_pilots.dies: "policy has died by SIGSEGV",
    bad_pilots.leaks: "of memory, above",
}


class Lockstep:
    """Waits as a vehicle in lockstep does: without end."""

    over = False

    def wait(self, source: Readable) -> bool:
        return wait_for_any(0.1, source)


class RealTime:
    """Waits for no more than a moment."""

    over = True

    def wait(self, source: Readable) -> bool:
        return wait_for_any(0.01, source)


class FastWall:
    """A wall clock on which a wait of a tenth takes seconds."""

    def __call__(self) -> float:
        return time.monotonic() * 50.0


def start(answer: Answer, *, bad_images: int = 1 << 30, **options: Any) -> WorkerPilot:
    limit = {"max_memory_bytes": memory_bytes(os.getpid()) + ROOM_BYTES}
    return WorkerPilot.start(Turning(answer, bad_images=bad_images), **(limit | options))


def image(number: int) -> Image:
    return Image(stamp_us=number * 50_000, sequence=number, rgb=RGB)


def answers(pilot: WorkerPilot, count: int) -> list[Decision | PartFailure | None]:
    try:
        return [pilot.decide(image(number), Lockstep()) for number in range(count)]
    finally:
        pilot.close()


def test_a_decision_comes_back_to_the_last_bit() -> None:
    there = good_decision()
    back = answers(start(bad_pilots.is_nothing), 1)[0]
    assert isinstance(back, Decision)
    for name in Decision.__slots__:
        np.testing.assert_array_equal(getattr(back, name), getattr(there, name))


@pytest.mark.parametrize(("answer", "words"), GOES_WRONG.items())
def test_what_goes_wrong_is_said_and_flown_on_from(answer: Answer, words: str) -> None:
    first, second, third, fourth = answers(start(answer, bad_images=1), 4)
    assert isinstance(first, Decision)
    assert isinstance(second, Decision)
    assert str(third) == words
    assert isinstance(fourth, Decision)


@pytest.mark.parametrize(("answer", "words"), GOES_WRONG.items())
def test_in_our_own_process_it_is_said_in_the_same_words(answer: Answer, words: str) -> None:
    if answer is bad_pilots.exits:
        pytest.skip("whoever ends the process works in one of its own")
    marker = PartMarker()
    pilot = InProcessPilot(bad_pilots.TurningPilot(answer, marker), marker)
    third = [pilot.decide(image(number)) for number in range(3)][-1]
    assert str(third) == words


@pytest.mark.parametrize(("answer", "words"), ENDS.items())
def test_a_worker_that_ends_or_leaks_is_given_up(answer: Answer, words: str) -> None:
    *_, third, fourth = answers(start(answer), 4)
    assert isinstance(third, PartFailure)
    assert words in str(third)
    assert fourth == third


def test_a_part_that_is_silent_for_long_is_given_up() -> None:
    *_, third = answers(start(bad_pilots.hangs, wall_s=FastWall()), 3)
    assert str(third) == "policy has not answered for 8 s"


def test_a_flight_that_goes_on_is_not_kept_waiting() -> None:
    pilot = start(bad_pilots.is_slow)
    try:
        assert isinstance(pilot.decide(image(0), Lockstep()), Decision)
        assert isinstance(pilot.decide(image(1), Lockstep()), Decision)
        began_s = time.monotonic()
        assert pilot.decide(image(2), RealTime()) is None
        assert time.monotonic() - began_s < 0.2
        assert isinstance(pilot.decide(image(3), Lockstep()), Decision)  # of the image before
    finally:
        pilot.close()


def test_a_worker_that_dies_between_images_is_noticed() -> None:
    pilot = start(bad_pilots.hangs)
    try:
        assert pilot.check() is None
        process_id = pilot._process_id
        assert process_id is not None
        os.kill(process_id, 9)
        assert wait_for_any(5.0, pilot)
        assert str(pilot.check()) == "policy has died by SIGKILL"
    finally:
        pilot.close()


def refusing(error: BaseException) -> Callable[[PartMarker], PilotMaker]:
    def load(_: PartMarker) -> PilotMaker:
        raise error

    return load


@pytest.mark.parametrize(
    ("load", "kind", "words"),
    [
        (refusing(ModelError("unknown model 'x'")), ModelError, "unknown model 'x'"),
        (refusing(UsageError("does not load")), UsageError, "does not load"),
        (refusing(SystemExit(0)), UsageError, "pilot raised SystemExit: 0 while it was loaded"),
        (
            lambda marker: lambda: bad_pilots.TurningPilot(bad_pilots.has_nan, marker),
            UsageError,
            "policy gave command that is not finite, when it was tried on a made-up image",
        ),
        (
            lambda marker: lambda: bad_pilots.TurningPilot(bad_pilots.ends, marker),
            UsageError,
            "policy has ended its process with exit code 0",
        ),
    ],
)
def test_what_does_not_load_or_work_is_refused(
    load: Any, kind: type[FlightstackError], words: str
) -> None:
    with pytest.raises(kind, match="^" + words.replace("(", r"\(")):
        WorkerPilot.start(load, max_memory_bytes=1e12)


def test_a_closed_worker_leaves_no_process() -> None:
    pilot = start(bad_pilots.hangs)
    process_id = pilot._process_id
    pilot.close()
    pilot.close()
    assert process_id is not None
    with pytest.raises(ProcessLookupError):
        os.kill(process_id, 0)
