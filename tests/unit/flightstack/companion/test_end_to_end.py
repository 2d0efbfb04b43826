"""An end-to-end policy: what it is told, what it may answer, and where it works."""

import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from flightstack.companion.piloting.failure import PartError, PartFailure, PartMarker
from flightstack.companion.piloting.in_worker import WorkerPilot, memory_bytes
from flightstack.companion.pilots.end_to_end import EndToEndPilot, observe, read_answer
from flightstack.mavlink.motion import MotionHistory
from flightstack.records import Decision, Image, Observation, Pose
from tests.unit.flightstack.companion.piloting.test_in_worker import Lockstep

FORWARD = np.array([1.0, 0.0, 0.0, 0.0])
ROOM_BYTES = 300e6


def image(number: int = 1, size: int = 64) -> Image:
    rgb = np.full((size, size, 3), 7, np.uint8)
    return Image(stamp_us=number * 50_000, sequence=number, rgb=rgb)


def pose(number: int = 1, **changed: Any) -> Pose:
    north = {"position_ned": (1.0, 2.0, -3.0), "velocity_ned": (2.0, 0.0, -0.5)}
    angles = {"roll_rad": 0.1, "pitch_rad": -0.2, "yaw_rad": math.pi / 2}
    return Pose(time_us=number * 50_000, **{**north, **angles, **changed})


def told(*poses: Pose) -> MotionHistory:
    motion = MotionHistory()
    for one in poses:
        motion.note(one)
    return motion


class Answering:
    """Answers whatever it was made to."""

    def __init__(self, answer: Any) -> None:
        self._answer = answer

    def reset(self) -> None:
        """Remember nothing."""

    def act(self, _: Observation) -> Any:
        return self._answer


class Telling:
    """Answers by what it is told, since the last reset alone."""

    def __init__(self) -> None:
        self._images = 0

    def reset(self) -> None:
        self._images = 0

    def act(self, observation: Observation) -> Any:
        self._images += 1
        return [*observation.velocity, observation.attitude[2]], np.full(4, self._images)


def test_it_is_told_its_velocity_along_its_heading_and_an_image_of_its_size() -> None:
    observation = observe(image(size=128), told(pose()))
    assert observation.image.shape == (64, 64, 3)
    assert observation.stamp_us == 50_000
    # heading east, moving north: to the left
    np.testing.assert_allclose(observation.velocity, [0.0, -2.0, -0.5], atol=1e-6)
    np.testing.assert_allclose(observation.attitude, [0.1, -0.2, math.pi / 2], atol=1e-6)


def test_before_any_telemetry_it_is_level_and_still() -> None:
    observation = observe(image(), MotionHistory())
    assert not observation.velocity.any()
    assert not observation.attitude.any()


def test_telemetry_of_another_moment_is_none() -> None:
    with pytest.raises(PartError, match="has no telemetry of this image's moment"):
        observe(image(100), told(pose(1)))


@pytest.mark.parametrize("answer", [FORWARD, [1, 0, 0, 0], (1.0, 0.0, 0.0, 0.0)])
def test_velocities_alone_claim_to_be_sure(answer: Any) -> None:
    command, stds = read_answer(answer)
    np.testing.assert_array_equal(command, FORWARD)
    assert stds.shape == (3, 4)
    assert not stds.any()


def test_one_uncertainty_is_aleatoric_and_three_are_told_apart() -> None:
    _, stds = read_answer((FORWARD, [1.0, 2.0, 3.0, 4.0]))
    np.testing.assert_array_equal(stds, [[1, 2, 3, 4], [0] * 4, [0] * 4])
    three = np.arange(12.0).reshape(3, 4)
    decision = EndToEndPilot(Answering((FORWARD, three)), told(pose())).decide(image())
    np.testing.assert_array_equal(decision.aleatoric_std, three[0])
    np.testing.assert_array_equal(decision.epistemic_std, three[1])
    np.testing.assert_array_equal(decision.perceptual_std, three[2])


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (None, "gave NoneType for velocities"),
        ("fast", "gave str for velocities"),
        ([1.0], r"gave velocities of shape \(1,\), not \(4,\)"),
        ([1.0, 0.0, 0.0, math.nan], "gave velocities that are not finite"),
        ((FORWARD, [1.0, 1.0, 1.0]), r"gave standard deviations of shape \(3,\)"),
        ((FORWARD, [-1.0, 0.0, 0.0, 0.0]), "gave standard deviations below 0"),
        ((FORWARD, np.full((3, 4), np.inf)), "gave standard deviations that are not finite"),
    ],
)
def test_what_is_no_answer_is_said(answer: Any, words: str) -> None:
    with pytest.raises(PartError, match=words):
        read_answer(answer)


def test_commands_stay_inside_the_limits() -> None:
    decision = EndToEndPilot(Answering([99.0, -99.0, 99.0, -99.0]), told(pose())).decide(image())
    np.testing.assert_array_equal(decision.command, [7.0, -3.0, 3.0, -1.0])
    assert decision.member_mean[0, 0] == 99.0


def test_in_its_worker_it_is_told_the_pose_of_each_image() -> None:
    motion = MotionHistory()

    def load(_: PartMarker) -> Callable[[], EndToEndPilot]:
        return lambda: EndToEndPilot(Telling(), motion)

    limit = memory_bytes(os.getpid()) + ROOM_BYTES
    pilot = WorkerPilot.start(load, motion, max_memory_bytes=limit)
    try:
        for number in (1, 2):
            motion.note(pose(number, velocity_ned=(0.0, number, 0.0)))
            decision = pilot.decide(image(number), Lockstep())
            assert isinstance(decision, Decision), decision
            np.testing.assert_allclose(
                decision.member_mean[0], [number, 0.0, 0.0, math.pi / 2], atol=1e-6
            )
            assert decision.aleatoric_std[0] == number  # the one that was tried is another
        late = pilot.decide(image(99), Lockstep())
        assert isinstance(late, PartFailure)
        assert str(late) == "pilot has no telemetry of this image's moment"
    finally:
        pilot.close()
