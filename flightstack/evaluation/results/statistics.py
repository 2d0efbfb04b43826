"""Means with intervals by bootstrap over tracks: trials of one track are no two witnesses.

References:
    Efron 1987, "Better bootstrap confidence intervals": BCa.
    Clopper and Pearson 1934: the exact interval of a share.
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import DegenerateDataWarning, binomtest, bootstrap

CONFIDENCE = 0.95
RESAMPLES = 9999
SEED = 20220527  # any: the same rows give the same intervals
BCA, PERCENTILE, EXACT, NO_SPREAD, ONE_TRACK = "bca", "percentile", "exact", "no spread", "one"

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanEstimate:
    """A mean over tracks and its interval; None where one track can tell none."""

    mean: float
    low: float | None
    high: float | None
    tracks: int
    method: str  # of the interval


def mean_over(values: Sequence[float]) -> MeanEstimate:
    """Estimate the mean of one value per track.

    All alike, they tell an interval without width: the true one may be wider. Values that are no
    numbers (of flights without a decision) are left out.
    """
    known = np.array([value for value in values if np.isfinite(value)], dtype=np.float64)
    if not len(known):
        return MeanEstimate(mean=float("nan"), low=None, high=None, tracks=0, method=ONE_TRACK)
    mean = float(known.mean())
    if len(known) == 1:
        return MeanEstimate(mean=mean, low=None, high=None, tracks=1, method=ONE_TRACK)
    if np.ptp(known) == 0.0:
        return MeanEstimate(mean=mean, low=mean, high=mean, tracks=len(known), method=NO_SPREAD)
    low, high, method = _interval(known)
    return MeanEstimate(mean=mean, low=low, high=high, tracks=len(known), method=method)


def share_over(values: Sequence[float]) -> MeanEstimate:
    """Estimate a share from one per track; where all are 0 or all are 1, by the exact interval."""
    found = mean_over(values)
    if found.method != NO_SPREAD or found.mean not in (0.0, 1.0):
        return found
    exact = binomtest(round(found.mean * found.tracks), found.tracks).proportion_ci(CONFIDENCE)
    return MeanEstimate(
        mean=found.mean,
        low=float(exact.low),
        high=float(exact.high),
        tracks=found.tracks,
        method=EXACT,
    )


def difference_over(first: Mapping[int, float], second: Mapping[int, float]) -> MeanEstimate:
    """Estimate the mean of first - second, both by track, over the tracks that both have."""
    return mean_over([first[track] - second[track] for track in sorted(first.keys() & second)])


def survival_over(passed: Sequence[Sequence[int]], gates: int) -> tuple[Floats, Floats, Floats]:
    """Share of trials that pass at least 1, 2, ... gates, and the ends of its band: (gates,) each.

    `passed` lists, for each track, the gates of its trials. The band is pointwise, by percentiles.
    """
    at = np.arange(1, gates + 1)
    shares = np.array([(np.array(track)[:, None] >= at).mean(axis=0) for track in passed])
    rng = np.random.default_rng(SEED)
    drawn = rng.integers(len(shares), size=(RESAMPLES, len(shares)))
    counts = np.apply_along_axis(np.bincount, 1, drawn, minlength=len(shares))
    means = counts @ shares / len(shares)
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile(means, [tail, 1.0 - tail], axis=0)
    return shares.mean(axis=0), low, high


def _interval(values: Floats) -> tuple[float, float, str]:
    for method in (BCA, PERCENTILE):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DegenerateDataWarning)
            warnings.simplefilter("ignore", RuntimeWarning)
            found = bootstrap(
                (values,),
                np.mean,
                n_resamples=RESAMPLES,
                confidence_level=CONFIDENCE,
                method="BCa" if method == BCA else "percentile",
                rng=np.random.default_rng(SEED),
            ).confidence_interval
        low, high = float(found.low), float(found.high)
        if np.isfinite(low) and np.isfinite(high):
            break
    return low, high, method
