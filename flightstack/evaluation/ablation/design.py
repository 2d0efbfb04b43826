"""Which strategies an ablation compares: the corners between de-mean and mi-mode, or all of them.

A strategy is a level of each factor: whom to follow, which statistic of them (`mode` together with
the preference for the nearer gate's side, which is the paper's rule), and how vx is set. Changing
one factor at a time from de-mean towards mi-mode, and from mi-mode back, visits each corner of this
cube once:

    de-mean = all/mean/same    mi-mode = mi/mode/lowest/near
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

MEMBER, STATISTIC, VX = "member choice", "mode", "slow-down"
FACTORS = (MEMBER, STATISTIC, VX)
PLAIN = {MEMBER: "all", STATISTIC: "mean", VX: "same"}  # de-mean
PAPERS = {MEMBER: "mi", STATISTIC: "mode/near", VX: "lowest"}  # mi-mode
LEVELS = {
    MEMBER: ("all", "mi", "mi-exact", "random", "best"),
    STATISTIC: ("mean", "median", "mode", "mode/near"),
    VX: ("same", "lowest", "lowest-mode"),
}
NAMES = {"all/mean/same": "de-mean", "mi/mode/lowest/near": "mi-mode"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Point:
    """One combination of levels."""

    member: str
    statistic: str
    vx: str

    @classmethod
    def of(cls, levels: Mapping[str, str]) -> "Point":
        """Make a point from a level of each factor."""
        return cls(member=levels[MEMBER], statistic=levels[STATISTIC], vx=levels[VX])

    @property
    def levels(self) -> dict[str, str]:
        """The level of each factor."""
        return dict(zip(FACTORS, (self.member, self.statistic, self.vx), strict=True))

    @property
    def strategy(self) -> str:
        """The strategy's name: its parts, or the paper's where it has one."""
        statistic, slash, side = self.statistic.partition("/")
        parts = "/".join((self.member, statistic, self.vx)) + slash + side
        return NAMES.get(parts, parts)


def corner(papers: Sequence[str]) -> Point:
    """Return the corner with the paper's level of these factors, the plain one of all others."""
    return Point.of({factor: (PAPERS if factor in papers else PLAIN)[factor] for factor in FACTORS})


def cube() -> tuple[Point, ...]:
    """Return the eight corners, from de-mean to mi-mode."""
    chosen = (itertools.combinations(FACTORS, count) for count in range(len(FACTORS) + 1))
    return tuple(corner(papers) for papers in itertools.chain.from_iterable(chosen))


def factorial(*, with_best: bool) -> tuple[Point, ...]:
    """Return all combinations; without the member choice `best` where no model knows who it is."""
    levels = [
        [level for level in LEVELS[factor] if with_best or level != "best"] for factor in FACTORS
    ]
    points = itertools.product(*levels)
    return tuple(Point(member=m, statistic=s, vx=v) for m, s, v in points)


def points_of(strategies: Iterable[str]) -> tuple[Point, ...]:
    """Recognise the design that these strategies were flown for: all combinations, or corners."""
    flown = set(strategies)
    for points in (factorial(with_best=True), factorial(with_best=False)):
        if {point.strategy for point in points} <= flown:
            return points
    return cube()
