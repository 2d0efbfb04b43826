"""Strategies by name: each one a member choice, a statistic, a rule for vx and a side preference.

`de-mean` and `mi-mode` are the paper's two. Any other combination is written out as
MEMBER/STATISTIC/VX or MEMBER/STATISTIC/VX/SIDE, for example `mi-exact/mean/slow:0.8` or
`all/mode/same/near`, so that each part can be ablated alone.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from flightstack.decision.members import MEMBERS, Aids
from flightstack.decision.mixture import split_variance
from flightstack.decision.parts import (
    DIRECTIONS,
    MAX_FACTOR,
    SIDES,
    SLOW_FACTOR,
    STATISTICS,
    VX,
    VX_RULES,
    Followed,
)
from flightstack.errors import UsageError
from flightstack.records import ActionSamples, Decision

STRATEGIES = {
    "de-mean": "all/mean/same",
    "mi-mode": "mi/mode/lowest/near",
}
FORM = "MEMBER/STATISTIC/VX[/SIDE]"


@runtime_checkable
class Strategy(Protocol):
    """Anything that turns a posterior predictive into a decision."""

    def decide(self, samples: ActionSamples) -> Decision:
        """Decide one command."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ComposedStrategy:
    """A strategy of named parts, for a course of one direction."""

    member: str  # of MEMBERS
    statistic: str  # of STATISTICS
    vx: str  # of VX_RULES
    vx_factor: float  # of the rule "slow"
    side: str  # of SIDES
    direction: str  # of DIRECTIONS
    aids: Aids

    def decide(self, samples: ActionSamples) -> Decision:
        """Choose whom to follow, take their statistic and their side, and set the pace."""
        choice = MEMBERS[self.member](samples, self.aids)
        followed = Followed.of(samples, choice, self.direction)
        command = SIDES[self.side](followed, STATISTICS[self.statistic](followed))
        command[VX] = VX_RULES[self.vx](followed, float(command[VX]), self.vx_factor)
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


def make_strategy(
    name: str, *, direction: str = "cw", seed: int = 0, best_member: tuple[int, ...] = ()
) -> Strategy:
    """Make a strategy from its name, or from its parts.

    `seed` is of the member choice "random"; `best_member` (4,) is whom "best" follows. Raises
    UsageError, with the known names, when there is no such strategy, part or direction.
    """
    if direction not in DIRECTIONS:
        raise UsageError(f"unknown direction {direction!r}: choose one of {', '.join(DIRECTIONS)}")
    parts = STRATEGIES.get(name, name).split("/")
    if len(parts) not in (3, 4):
        known = ", ".join(sorted(STRATEGIES))
        raise UsageError(
            f"unknown strategy {name!r}: choose one of {known}, or {FORM}, "
            "or bring your own as my_package:MyStrategy"
        )
    member, statistic, pace, side = [*parts, "none"][:4]
    vx, colon, factor = pace.partition(":")
    kinds: dict[str, tuple[str, Collection[str]]] = {
        "member choice": (member, MEMBERS),
        "statistic": (statistic, STATISTICS),
        "vx rule": (vx, VX_RULES),
        "side preference": (side, SIDES),
    }
    for kind, (part, of_kind) in kinds.items():
        if part not in of_kind:
            raise UsageError(
                f"unknown {kind} {part!r} in strategy {name!r}: choose one of {', '.join(of_kind)}"
            )
    if member == "best" and not best_member:
        raise UsageError(
            f"strategy {name!r}: the model does not record which member is best; "
            "choose another strategy, or run 'python -m flightstack.training calibrate' on it"
        )
    return ComposedStrategy(
        member=member,
        statistic=statistic,
        vx=vx,
        vx_factor=_factor(vx, factor, name) if colon else SLOW_FACTOR,
        side=side,
        direction=direction,
        aids=Aids(rng=np.random.default_rng(seed), best_member=best_member),
    )


def _factor(rule: str, text: str, name: str) -> float:
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if rule != "slow" or not 0.0 < factor <= MAX_FACTOR:
        raise UsageError(
            f"strategy {name!r}: only 'slow' takes a factor, above 0 and at most "
            f"{MAX_FACTOR:g}, as 'slow:0.8'"
        )
    return factor
