import numpy as np
import pytest
from scipy.stats import norm

from flightstack.evaluation.offline.scores import LEVELS, coverage_curve, detection, mixture_scores

RNG = np.random.default_rng(0)


def test_scores_of_one_gaussian_are_the_textbooks() -> None:
    mean, std = RNG.normal(0.0, 1.0, (100, 1)), RNG.uniform(0.5, 2.0, (100, 1))
    target = RNG.normal(0.0, 1.0, 100)
    scores = mixture_scores(mean, std**2, target)
    offset = (target - mean[:, 0]) / std[:, 0]
    crps = std[:, 0] * (offset * (2 * norm.cdf(offset) - 1) + 2 * norm.pdf(offset) - np.pi**-0.5)
    assert scores["crps"] == pytest.approx(crps.mean())
    assert scores["nll"] == pytest.approx(-np.mean(norm.logpdf(target, mean[:, 0], std[:, 0])))
    assert scores["rmse"] == pytest.approx(np.sqrt(np.mean((mean[:, 0] - target) ** 2)))


def test_crps_of_a_mixture_agrees_with_monte_carlo() -> None:
    mean, std = np.array([[-1.0, 1.0, 1.5]]), np.array([[0.3, 0.5, 0.1]])
    chosen = RNG.integers(3, size=(2, 200_000))
    first, second = RNG.normal(mean[0][chosen], std[0][chosen])
    target = np.array([0.4])
    expected = np.abs(first - target).mean() - 0.5 * np.abs(first - second).mean()
    assert mixture_scores(mean, std**2, target)["crps"] == pytest.approx(expected, abs=0.01)


def test_true_predictions_cover_what_they_say() -> None:
    mean = RNG.normal(0.0, 1.0, (20_000, 1))
    target = mean[:, 0] + RNG.normal(0.0, 0.5, 20_000)
    curve = coverage_curve(mean, np.full(mean.shape, 0.25), target)
    assert curve == pytest.approx(LEVELS, abs=0.015)  # 4 standard deviations of a binomial


def test_detection_is_one_half_for_noise_and_one_for_certainty() -> None:
    noise = RNG.normal(0.0, 1.0, (2, 4000))
    assert detection(*noise) == pytest.approx(0.5, abs=0.03)
    assert detection(noise[0], noise[0] + 100.0) == 1.0
