import math

import numpy as np
import pytest
from scipy.stats import bootstrap

from flightstack.evaluation.results.statistics import (
    BCA,
    EXACT,
    NO_SPREAD,
    ONE_TRACK,
    RESAMPLES,
    SEED,
    difference_over,
    mean_over,
    share_over,
    survival_over,
)


def test_the_interval_is_the_librarys_bca() -> None:
    values = np.random.default_rng(1).integers(0, 33, 50).astype(float)
    found = mean_over(values.tolist())
    rng = np.random.default_rng(SEED)
    same = bootstrap((values,), np.mean, n_resamples=RESAMPLES, rng=rng).confidence_interval
    assert (found.mean, found.low, found.high) == (values.mean(), same.low, same.high)
    assert (found.method, found.tracks) == (BCA, 50)


def test_the_interval_covers_the_truth_about_as_often_as_it_says() -> None:
    # Trials end early or not at all; 100 samples of 30 tracks. 95 % +- 3 standard deviations of
    # a binomial share, less BCa's known shortfall at this size.
    rng = np.random.default_rng(2)
    truth = 0.6 * 32 + 0.4 * 8
    covered = 0
    for _ in range(100):
        found = mean_over(np.where(rng.random(30) < 0.6, 32.0, 8.0).tolist())
        assert found.low is not None
        assert found.high is not None
        covered += found.low <= truth <= found.high
    assert 86 <= covered <= 100


def test_without_spread_the_interval_has_no_width_and_says_so() -> None:
    found = mean_over([32.0] * 6)
    assert (found.mean, found.low, found.high, found.method) == (32.0, 32.0, 32.0, NO_SPREAD)


def test_one_odd_track_among_many_has_an_interval() -> None:
    found = mean_over([32.0] * 49 + [3.0])
    assert found.low is not None
    assert found.high is not None
    assert 25.0 < found.low < found.mean < found.high <= 32.0


@pytest.mark.parametrize("values", [[5.0], [5.0, math.nan]])
def test_one_track_tells_no_interval(values: list[float]) -> None:
    found = mean_over(values)
    assert (found.mean, found.low, found.high, found.method) == (5.0, None, None, ONE_TRACK)


def test_a_share_of_all_or_none_has_the_exact_interval() -> None:
    whole, none = share_over([1.0] * 50), share_over([0.0] * 50)
    assert (whole.method, whole.high) == (EXACT, 1.0)
    assert whole.low == pytest.approx(0.025 ** (1 / 50))  # Clopper and Pearson, all of n
    assert none.low == 0.0
    assert none.high == pytest.approx(1 - 0.025 ** (1 / 50))
    assert share_over([1.0, 0.0, 1.0, 0.5]).method == BCA


def test_differences_are_paired_by_track() -> None:
    first = {track: 20.0 + track % 7 for track in range(30)}
    second = {track: value - 1.0 - track % 2 for track, value in first.items()}
    found = difference_over(first, second | {99: 0.0})
    assert found.mean == pytest.approx(1.5)
    assert found.tracks == 30
    assert found.low is not None
    assert 1.2 < found.low < 1.5  # far narrower than the spread over tracks


def test_survival_falls_from_all_to_whole_courses() -> None:
    share, low, high = survival_over([[32, 32], [4, 32], [0, 1]], 32)
    assert share[0] == pytest.approx(5 / 6)
    assert share[3] == pytest.approx(4 / 6)
    assert share[31] == pytest.approx(3 / 6)
    assert (np.diff(share) <= 0).all()
    assert (low <= share).all()
    assert (share <= high).all()
