"""Scores of predictive mixtures, and of uncertainty as a detector, by the libraries that have them.

References:
    Gneiting and Raftery 2007, "Strictly proper scoring rules": NLL and CRPS.
    Kuleshov et al. 2018, "Accurate uncertainties for deep learning": the calibration curve.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from flightstack.libraries import load_library

LEVELS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)  # central intervals
CHUNK = 32  # images whose CRPS is computed at once: it compares all pairs of components


def mixture_scores(
    mean: NDArray[np.float64],  # (K, S) components of one velocity
    var: NDArray[np.float64],  # (K, S)
    target: NDArray[np.float64],  # (K,)
) -> dict[str, float]:
    """NLL in nats, CRPS and RMSE in the velocity's unit, averaged over the images."""
    rules = load_library("scoringrules", "evaluation")
    std = np.sqrt(var)
    starts = range(0, len(target), CHUNK)
    crps = [
        rules.crps_mixnorm(target[k : k + CHUNK], mean[k : k + CHUNK], std[k : k + CHUNK])
        for k in starts
    ]
    return {
        "nll": float(np.mean(rules.logs_mixnorm(target, mean, std))),
        "crps": float(np.mean(np.concatenate(crps))),
        "rmse": float(np.sqrt(np.mean(np.square(mean.mean(axis=1) - target)))),
    }


def coverage_curve(
    mean: NDArray[np.float64], var: NDArray[np.float64], target: NDArray[np.float64]
) -> list[float]:
    """Share of targets (K,) inside the central interval of each of LEVELS, of mixtures (K, S)."""
    below = ndtr((target[:, np.newaxis] - mean) / np.sqrt(var)).mean(axis=1)
    return [float(np.mean(np.abs(below - 0.5) < level / 2.0)) for level in LEVELS]


def detection(plain: NDArray[np.float64], odd: NDArray[np.float64]) -> float:
    """AUROC of a score that ought to be higher on odd images than on plain ones."""
    truth = np.concatenate([np.zeros(len(plain)), np.ones(len(odd))])
    metrics = load_library("sklearn.metrics", "evaluation")
    return float(metrics.roc_auc_score(truth, np.concatenate([plain, odd])))
