from collections.abc import Iterable

import numpy as np
import pytest

from flightstack.evaluation.ablation.design import (
    FACTORS,
    MEMBER,
    PAPERS,
    STATISTIC,
    VX,
    Point,
    corner,
    cube,
    factorial,
)
from flightstack.evaluation.ablation.effects import main_effects, one_at_a_time, shares

TRACKS = range(12)


def gates(
    point: Point,
    *,
    member: float = 0.0,
    mode: float = 0.0,
    slow: float = 0.0,
    together: float = 0.0,
) -> dict[int, float]:
    """Gates by track, where each factor adds its own, and mode with slow-down something more."""
    rng = np.random.default_rng(5)  # the tracks differ, alike for all
    has = {factor: point.levels[factor] == PAPERS[factor] for factor in FACTORS}
    added = member * has[MEMBER] + mode * has[STATISTIC] + slow * has[VX]
    added += together * (has[STATISTIC] and has[VX])
    return {track: 10.0 + float(rng.normal()) + added for track in TRACKS}


def values(points: Iterable[Point], **effects: float) -> dict[Point, dict[int, float]]:
    return {point: gates(point, **effects) for point in points}


def test_factors_that_add_up_have_the_shares_that_they_add() -> None:
    found = shares(values(cube(), member=1.0, mode=-2.0, slow=5.0))
    assert [found[f].mean for f in FACTORS] == pytest.approx([1.0, -2.0, 5.0])


def test_what_two_make_together_is_halved_between_them() -> None:
    made = values(cube(), slow=3.0, together=4.0)
    found = shares(made)
    assert [found[f].mean for f in FACTORS] == pytest.approx([0.0, 2.0, 5.0])
    whole = np.mean([made[corner(FACTORS)][t] - made[corner(())][t] for t in TRACKS])
    assert sum(one.mean for one in found.values()) == pytest.approx(whole)


def test_one_at_a_time_sees_it_from_both_ends() -> None:
    found = one_at_a_time(values(cube(), slow=3.0, together=4.0))
    assert [one.mean for one in found[STATISTIC]] == pytest.approx([0.0, 4.0])
    assert [one.mean for one in found[VX]] == pytest.approx([3.0, 7.0])


def test_intervals_are_over_tracks() -> None:
    made = values(cube(), slow=3.0)
    for track in TRACKS:  # slowing down helps on half of the tracks alone
        if track % 2:
            for point in cube():
                if point.vx == PAPERS[VX]:
                    made[point][track] -= 3.0
    share = shares(made)[VX]
    assert share.mean == pytest.approx(1.5)
    assert share.low is not None
    assert share.high is not None
    assert share.low < 1.0
    assert share.high > 2.0
    assert share.tracks == len(TRACKS)


def test_main_effects_average_over_all_else() -> None:
    found = main_effects(values(factorial(with_best=True), member=1.0, slow=2.0))
    assert found[MEMBER, "mi"].mean == pytest.approx(1.0)
    assert found[MEMBER, "random"].mean == pytest.approx(0.0)
    assert found[VX, "lowest"].mean == pytest.approx(2.0)
    assert (VX, "same") not in found
