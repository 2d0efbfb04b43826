"""Recalibrate predicted variances, so that 90 % intervals cover about 90 % of what happens.

One factor a velocity on the predicted (aleatoric) variance, fitted on validation data, and only
where the mixture's interval covers too little or too much. The spread of the means stays as it is.
A deterministic policy predicts one small variance everywhere; its factor makes that the variance of
what it leaves unexplained, which is what training by squared error takes for granted.
What is left alone lies well within the 85 to 95 % that are aimed at on other tracks.

Reference: Levi et al. 2022, "Evaluating and calibrating uncertainty prediction in regression":
scaling the predicted deviation.
"""

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtr

from flightstack.arrays import PerComponent, PerImage
from flightstack.records import VELOCITIES

INTERVAL = 0.90  # central
GOOD_COVERAGE = (0.88, 0.92)  # of it; left alone
MAX_LOG_FACTOR = np.log(1000.0)


def coverage(
    mean: Float64[NDArray[np.float64], "S K *V"],
    var: Float64[NDArray[np.float64], "S K *V"],
    target: Float64[NDArray[np.float64], " K *V"],
) -> Float64[NDArray[np.float64], "*V"]:
    """Share of targets inside the central interval of their mixtures, of one velocity or of all."""
    below = ndtr((target - mean) / np.sqrt(var)).mean(axis=0)
    tail = (1.0 - INTERVAL) / 2.0
    return np.asarray(((below > tail) & (below < 1.0 - tail)).mean(axis=0))


def variance_factor(mean: PerComponent, var: PerComponent, target: PerImage) -> tuple[float, ...]:
    """Fit the factor of each velocity, 1 where none is needed: (4,)."""
    covered = coverage(mean, var, target)
    low, high = GOOD_COVERAGE
    return tuple(
        1.0 if low <= covered[k] <= high else _fit(mean[..., k], var[..., k], target[..., k])
        for k in range(len(VELOCITIES))
    )


def _fit(
    mean: Float64[NDArray[np.float64], "S K"],
    var: Float64[NDArray[np.float64], "S K"],
    target: Float64[NDArray[np.float64], " K"],
) -> float:
    """Find the factor that covers INTERVAL, or come as close as the bounds allow."""

    def excess(log_factor: float) -> float:
        return float(coverage(mean, var * np.exp(log_factor), target)) - INTERVAL

    if excess(-MAX_LOG_FACTOR) > 0.0:  # the means alone spread too far
        return float(np.exp(-MAX_LOG_FACTOR))
    if excess(MAX_LOG_FACTOR) < 0.0:
        return float(np.exp(MAX_LOG_FACTOR))
    return float(np.exp(brentq(excess, -MAX_LOG_FACTOR, MAX_LOG_FACTOR, xtol=0.005)))
