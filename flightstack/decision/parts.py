"""The named parts that a strategy is made of: whom to follow, what of it, and how fast.

Sides: on a clockwise course the nearer of two visible gates stands left of the one after it, so the
left-most mode flies through the right gate; on an anticlockwise one everything is mirrored.
Left is negative: vy points right, and yaw rate turns clockwise.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.decision.density import Modes, find_modes
from flightstack.decision.information import gaussian_score, quadrature_score
from flightstack.records import ALL_MEMBERS, VELOCITIES, ActionSamples

VX, VY, VZ, YAW_RATE = range(len(VELOCITIES))
SLOW_FACTOR = 0.7  # the constant slow-down that any cleverer rule has to beat

DIRECTIONS = ("cw", "ccw")  # of the course, seen from above


@dataclass(frozen=True, slots=True, kw_only=True)
class MemberChoice:
    """Whom to follow, per velocity, and the scores that were looked at."""

    member: NDArray[np.int64]  # (4,) or ALL_MEMBERS
    score: NDArray[np.float64]  # (N, 4) nats


@dataclass(frozen=True, slots=True, kw_only=True)
class Followed:
    """The predicted means of those who are followed."""

    values: NDArray[np.float64]  # (M, 4) of one member each, or (N M, 4) of all
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


def all_members(samples: ActionSamples) -> MemberChoice:
    """Pool them all."""
    everyone = np.full(len(VELOCITIES), ALL_MEMBERS)
    return MemberChoice(member=everyone, score=gaussian_score(samples))


def least_gaussian_score(samples: ActionSamples) -> MemberChoice:
    """Follow the member of least MI score by the matched Gaussian, as the paper's author does."""
    score = gaussian_score(samples)
    return MemberChoice(member=score.argmin(axis=0), score=score)


def least_quadrature_score(samples: ActionSamples) -> MemberChoice:
    """Follow the member of least exact MI score."""
    score = quadrature_score(samples)
    return MemberChoice(member=score.argmin(axis=0), score=score)


def mean(followed: Followed) -> NDArray[np.float64]:
    """Take the mean of the means, (4,)."""
    return np.asarray(followed.values.mean(axis=0))


def median(followed: Followed) -> NDArray[np.float64]:
    """Take their median, (4,)."""
    return np.asarray(np.median(followed.values, axis=0))


def densest_mode(followed: Followed) -> NDArray[np.float64]:
    """Take the highest peak of their density, (4,)."""
    return followed.modes.densest


def near_side_mode(followed: Followed) -> NDArray[np.float64]:
    """Take the mode of vy and yaw rate on the nearer gate's side, and the softest of vz, (4,)."""
    modes = followed.modes
    sideways = modes.lowest if followed.direction == "cw" else modes.highest
    return np.array([modes.lowest[VX], sideways[VY], modes.softest[VZ], sideways[YAW_RATE]])


def same_vx(followed: Followed, statistic: float) -> float:  # noqa: ARG001
    """Keep what the statistic gave."""
    return statistic


def lowest_vx(followed: Followed, statistic: float) -> float:  # noqa: ARG001
    """Fly the lowest predicted mean: the author's conservative choice."""
    return float(followed.values[:, VX].min())


def lowest_mode_vx(followed: Followed, statistic: float) -> float:  # noqa: ARG001
    """Fly the lowest mode."""
    return float(followed.modes.lowest[VX])


def slow_vx(followed: Followed, statistic: float) -> float:  # noqa: ARG001
    """Fly a constant share of what the statistic gave, however sure it is."""
    return SLOW_FACTOR * statistic


MEMBERS: dict[str, Callable[[ActionSamples], MemberChoice]] = {
    "all": all_members,
    "mi": least_gaussian_score,
    "mi-exact": least_quadrature_score,
}
STATISTICS: dict[str, Callable[[Followed], NDArray[np.float64]]] = {
    "mean": mean,
    "median": median,
    "mode": densest_mode,
    "near-side-mode": near_side_mode,
}
VX_RULES: dict[str, Callable[[Followed, float], float]] = {
    "same": same_vx,
    "lowest": lowest_vx,
    "lowest-mode": lowest_mode_vx,
    "slow": slow_vx,
}
