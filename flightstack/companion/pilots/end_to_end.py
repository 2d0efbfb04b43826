"""Fly by one part of a user's own, from image to velocities: an end-to-end policy.

image, and the vehicle's estimate at its stamp --> act --> velocities [, how unsure they are]
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flightstack import extensions
from flightstack.companion.piloting.failure import PartError, PartMarker
from flightstack.companion.piloting.protocols import PilotLoader, PilotMaker
from flightstack.frames import body_from_ned
from flightstack.mavlink.motion import MotionHistory
from flightstack.perception.preprocessing import fit_image
from flightstack.policy.scales import VelocityRange
from flightstack.records import ALL_MEMBERS, VELOCITIES, Decision, Image, Observation

WIDTH = len(VELOCITIES)
PARTS = 3  # of an uncertainty: aleatoric, epistemic, perceptual
LEVEL_AND_STILL = (0.0, 0.0, 0.0)
Velocities = ArrayLike  # (4,) m/s, m/s, m/s, rad/s
Stds = ArrayLike  # (4,), or (3, 4): aleatoric, epistemic, perceptual


class EndToEndPolicy(Protocol):
    """What a user brings; it may remember what it was shown since `reset`."""

    def reset(self) -> None:
        """Forget all: a flight begins."""

    def act(self, observation: Observation) -> Velocities | tuple[Velocities, Stds]:
        """Answer an image by four velocities; with their standard deviations, if it knows them."""


class EndToEndPilot:
    """Decides by such a policy for one image after another; commands stay inside the limits."""

    def __init__(
        self, policy: EndToEndPolicy, motion: MotionHistory, limits: VelocityRange | None = None
    ) -> None:
        self._policy, self._motion = policy, motion
        self._limits = VelocityRange() if limits is None else limits

    def decide(self, image: Image) -> Decision:
        """Ask it; raises PartError where it gives no velocities, or no telemetry tells enough."""
        answer = self._policy.act(observe(image, self._motion))
        command, stds = read_answer(answer)
        return Decision(
            command=self._limits.clip(command),
            aleatoric_std=stds[0],
            epistemic_std=stds[1],
            perceptual_std=stds[2],
            score=np.zeros((1, WIDTH)),
            member=np.full(WIDTH, ALL_MEMBERS),
            modes=np.ones(WIDTH, np.int64),
            member_mean=command[None],
        )


def end_to_end_loader(
    name: str, motion: MotionHistory, seed: int = 0, *, direction: str = "cw"
) -> PilotLoader:
    """Return what makes any number of equal pilots of the factory that a user names.

    Raises UsageError where it does not load, when it makes one.
    """

    def load(_: PartMarker) -> PilotMaker:
        return make

    def make() -> EndToEndPilot:
        policy = make_end_to_end(name, seed, direction=direction)
        policy.reset()
        return EndToEndPilot(policy, motion)

    return load


def make_end_to_end(name: str, seed: int = 0, *, direction: str = "cw") -> EndToEndPolicy:
    """Make an end-to-end policy by its factory's name; raises UsageError, in one line."""
    made: EndToEndPolicy = extensions.make(extensions.PILOT, name, direction=direction, seed=seed)
    return made


def observe(image: Image, motion: MotionHistory) -> Observation:
    """Put an image and the telemetry of its moment together; before any, level and still.

    Raises PartError where telemetry has been told, and none of that moment.
    """
    pose = motion.at(image.stamp_us)
    if pose is None and motion.latest is not None:
        raise PartError("has no telemetry of this image's moment")
    velocity, attitude = LEVEL_AND_STILL, LEVEL_AND_STILL
    if pose is not None:
        velocity = body_from_ned(pose.velocity_ned, pose.yaw_rad)
        attitude = (pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
    return Observation(
        stamp_us=image.stamp_us,
        image=fit_image(image.rgb),
        velocity=np.array(velocity, np.float32),
        attitude=np.array(attitude, np.float32),
    )


def read_answer(answer: object) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return velocities (4,) and standard deviations (3, 4); raises PartError.

    One standard deviation for each velocity is that of one Gaussian, and as such aleatoric.
    """
    command, stds = answer if isinstance(answer, tuple) and len(answer) == 2 else (answer, None)
    parts = np.zeros((PARTS, WIDTH))
    if stds is not None:
        given = _numbers(stds, "standard deviations", lambda s: s in ((WIDTH,), parts.shape))
        if (given < 0.0).any():
            raise PartError("gave standard deviations below 0")
        parts[: len(np.atleast_2d(given))] = given
    return _numbers(command, "velocities", lambda shape: shape == (WIDTH,)), parts


def _numbers(
    values: object, name: str, fits: Callable[[tuple[int, ...]], bool]
) -> NDArray[np.float64]:
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        array = None
    if array is None or values is None:
        raise PartError(f"gave {type(values).__name__} for {name}")
    if not fits(array.shape):
        raise PartError(f"gave {name} of shape {array.shape}, not ({WIDTH},)")
    if not np.isfinite(array).all():
        raise PartError(f"gave {name} that are not finite")
    return array
