"""Strategies by name: each one a member choice, a statistic and a rule for vx.

`de-mean` and `mi-mode` are the paper's two. Any other combination is written out as
MEMBER/STATISTIC/VX, for example `mi-exact/mean/slow`, so that each part can be ablated alone.
"""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flightstack.decision.mixture import split_variance
from flightstack.decision.parts import (
    DIRECTIONS,
    MEMBERS,
    STATISTICS,
    VX,
    VX_RULES,
    Followed,
)
from flightstack.errors import UsageError
from flightstack.records import ActionSamples, Decision

STRATEGIES = {
    "de-mean": "all/mean/same",
    "mi-mode": "mi/near-side-mode/lowest",
}


class Strategy(Protocol):
    """Anything that turns a posterior predictive into a decision."""

    def decide(self, samples: ActionSamples) -> Decision:
        """Decide one command."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ComposedStrategy:
    """A strategy of three named parts, for a course of one direction."""

    member: str  # of MEMBERS
    statistic: str  # of STATISTICS
    vx: str  # of VX_RULES
    direction: str  # of DIRECTIONS

    def decide(self, samples: ActionSamples) -> Decision:
        """Choose whom to follow, take their statistic, and set the pace."""
        choice = MEMBERS[self.member](samples)
        followed = Followed.of(samples, choice, self.direction)
        command = STATISTICS[self.statistic](followed)
        command[VX] = VX_RULES[self.vx](followed, float(command[VX]))
        parts = split_variance(samples)
        return Decision(
            command=command,
            aleatoric_std=np.sqrt(parts.aleatoric),
            epistemic_std=np.sqrt(parts.policy),
            perceptual_std=np.sqrt(parts.latent),
            score=choice.score,
            member=choice.member,
            modes=followed.modes.count,
            member_mean=samples.mean.mean(axis=1),
        )


def make_strategy(name: str, *, direction: str = "cw") -> Strategy:
    """Make a strategy from its name, or from MEMBER/STATISTIC/VX.

    Raises UsageError, with the known names, when there is no such strategy, part or direction.
    """
    if direction not in DIRECTIONS:
        raise UsageError(f"unknown direction {direction!r}: choose one of {', '.join(DIRECTIONS)}")
    parts = STRATEGIES.get(name, name).split("/")
    if len(parts) != 3:
        raise UsageError(
            f"unknown strategy {name!r}: choose one of {', '.join(sorted(STRATEGIES))}, "
            "or MEMBER/STATISTIC/VX"
        )
    kinds: dict[str, Collection[str]] = {
        "member choice": MEMBERS,
        "statistic": STATISTICS,
        "vx rule": VX_RULES,
    }
    for (kind, known), part in zip(kinds.items(), parts, strict=True):
        if part not in known:
            raise UsageError(
                f"unknown {kind} {part!r} in strategy {name!r}: choose one of {', '.join(known)}"
            )
    return ComposedStrategy(member=parts[0], statistic=parts[1], vx=parts[2], direction=direction)
