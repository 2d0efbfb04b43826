"""The named choices of whom to follow: every member, the most informative, any, or the best."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from flightstack.arrays import CountPerVelocity, PerMember
from flightstack.decision.information import gaussian_score, quadrature_score
from flightstack.records import ALL_MEMBERS, VELOCITIES, ActionSamples


@dataclass(frozen=True, slots=True, kw_only=True)
class Aids:
    """What a choice may need beside the predictions."""

    rng: np.random.Generator
    best_member: tuple[int, ...]  # (4,) on validation data, by velocity; empty where not known


@dataclass(frozen=True, slots=True, kw_only=True)
class MemberChoice:
    """Whom to follow, per velocity, and the scores that were looked at."""

    member: CountPerVelocity  # or ALL_MEMBERS
    score: PerMember  # nats


def all_members(samples: ActionSamples, aids: Aids) -> MemberChoice:  # noqa: ARG001
    """Pool them all."""
    everyone = np.full(len(VELOCITIES), ALL_MEMBERS)
    return MemberChoice(member=everyone, score=gaussian_score(samples))


def min_gaussian_score(samples: ActionSamples, aids: Aids) -> MemberChoice:  # noqa: ARG001
    """Follow the member of least MI score by the matched Gaussian, as the paper's author does."""
    score = gaussian_score(samples)
    return MemberChoice(member=score.argmin(axis=0), score=score)


def min_quadrature_score(samples: ActionSamples, aids: Aids) -> MemberChoice:  # noqa: ARG001
    """Follow the member of least exact MI score."""
    score = quadrature_score(samples)
    return MemberChoice(member=score.argmin(axis=0), score=score)


def random_member(samples: ActionSamples, aids: Aids) -> MemberChoice:
    """Follow anyone, drawn anew for every velocity of every decision."""
    member = aids.rng.integers(len(samples.mean), size=len(VELOCITIES))
    return MemberChoice(member=member, score=gaussian_score(samples))


def best_member(samples: ActionSamples, aids: Aids) -> MemberChoice:
    """Follow the member that was best on validation data, whatever it says now."""
    return MemberChoice(member=np.array(aids.best_member), score=gaussian_score(samples))


MEMBERS: dict[str, Callable[[ActionSamples, Aids], MemberChoice]] = {
    "all": all_members,
    "mi": min_gaussian_score,
    "mi-exact": min_quadrature_score,
    "random": random_member,
    "best": best_member,
}
