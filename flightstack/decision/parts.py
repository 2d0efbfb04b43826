"""The named parts that a strategy makes a command with: what of the followed, how fast, which side.

Sides: on a clockwise course the nearer of two visible gates stands left of the one after it, so the
left-most mode flies through the right gate; on an anticlockwise one everything is mirrored.
Left is negative: vy points right, and yaw rate turns clockwise.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.arrays import PerVelocity
from flightstack.decision.density import Modes, find_modes
from flightstack.decision.members import MemberChoice
from flightstack.records import ALL_MEMBERS, VELOCITIES, ActionSamples

VX, VY, VZ, YAW_RATE = range(len(VELOCITIES))
SLOW_FACTOR = 0.7  # of the rule "slow"; "slow:0.8" names another
MAX_FACTOR = 2.0  # above 1 it hastens: so a control can fly as fast as whatever it controls

DIRECTIONS = ("cw", "ccw")  # of the course, seen from above


@dataclass(frozen=True, slots=True, kw_only=True)
class Followed:
    """The predicted means of those who are followed."""

    values: Float64[NDArray[np.float64], "S 4"]  # M of one member each, or N M of all
    modes: Modes
    direction: str  # of the course, one of DIRECTIONS

    @classmethod
    def of(cls, samples: ActionSamples, choice: MemberChoice, direction: str) -> "Followed":
        """Gather the means and find their modes."""
        if (choice.member == ALL_MEMBERS).all():
            values = samples.mean.reshape(-1, len(VELOCITIES))
        else:
            values = samples.mean[choice.member, :, np.arange(len(VELOCITIES))].T
        return cls(values=values, modes=find_modes(values), direction=direction)


def mean(followed: Followed) -> PerVelocity:
    """Take the mean of the means."""
    return np.asarray(followed.values.mean(axis=0))


def median(followed: Followed) -> PerVelocity:
    """Take their median."""
    return np.asarray(np.median(followed.values, axis=0))


def densest_mode(followed: Followed) -> PerVelocity:
    """Take the highest peak of their density."""
    return followed.modes.densest


def same_vx(followed: Followed, statistic: float, factor: float) -> float:  # noqa: ARG001
    """Keep what the statistic gave."""
    return statistic


def lowest_vx(followed: Followed, statistic: float, factor: float) -> float:  # noqa: ARG001
    """Fly the lowest predicted mean: the author's conservative choice."""
    return float(followed.values[:, VX].min())


def lowest_mode_vx(followed: Followed, statistic: float, factor: float) -> float:  # noqa: ARG001
    """Fly the lowest mode."""
    return float(followed.modes.lowest[VX])


def slow_vx(followed: Followed, statistic: float, factor: float) -> float:  # noqa: ARG001
    """Fly a constant share of what the statistic gave, however sure it is."""
    return factor * statistic


def no_side(followed: Followed, command: PerVelocity) -> PerVelocity:  # noqa: ARG001
    """Keep what the statistic gave."""
    return command


def near_side(followed: Followed, command: PerVelocity) -> PerVelocity:
    """Where there are several modes: the nearer gate's side of vy and yaw rate, the softest vz."""
    modes = followed.modes
    sideways = modes.lowest if followed.direction == "cw" else modes.highest
    preferred = np.array([command[VX], sideways[VY], modes.softest[VZ], sideways[YAW_RATE]])
    return np.where(modes.count > 1, preferred, command)


STATISTICS: dict[str, Callable[[Followed], PerVelocity]] = {
    "mean": mean,
    "median": median,
    "mode": densest_mode,
}
VX_RULES: dict[str, Callable[[Followed, float, float], float]] = {
    "same": same_vx,
    "lowest": lowest_vx,
    "lowest-mode": lowest_mode_vx,
    "slow": slow_vx,
}
SIDES: dict[str, Callable[[Followed, PerVelocity], PerVelocity]] = {
    "none": no_side,
    "near": near_side,
}
