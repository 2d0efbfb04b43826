from typing import Any

import pytest

from flightstack.decision.strategies import make_strategy
from flightstack.evaluation.ablation.design import FACTORS, Point, corner, cube, factorial


def test_the_corners_lead_from_de_mean_to_mi_mode_one_factor_at_a_time() -> None:
    points = cube()
    assert len(set(points)) == 8
    assert (points[0].strategy, points[-1].strategy) == ("de-mean", "mi-mode")
    assert [p.strategy for p in points[1:4]] == [
        *("mi/mean/same", "all/mode/same/near", "all/mean/lowest"),
    ]
    one_less = [corner([f for f in FACTORS if f != factor]).strategy for factor in FACTORS]
    assert one_less == ["all/mode/lowest/near", "mi/mean/lowest", "mi/mode/same/near"]
    assert set(one_less) <= {p.strategy for p in points}


def test_the_factorial_has_all_combinations_and_the_corners_among_them() -> None:
    points = factorial(with_best=True)
    assert len(set(points)) == 5 * 4 * 3
    assert set(cube()) <= set(points)
    assert len(factorial(with_best=False)) == 4 * 4 * 3


@pytest.mark.parametrize("point", factorial(with_best=True))
def test_every_point_is_a_strategy(point: Point) -> None:
    made: Any = make_strategy(point.strategy, best_member=(0, 0, 0, 0))
    statistic = point.statistic.removesuffix("/near")
    assert (made.member, made.statistic, made.vx) == (point.member, statistic, point.vx)
