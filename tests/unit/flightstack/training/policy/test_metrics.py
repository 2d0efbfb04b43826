import numpy as np
import pytest
from scipy.stats import norm

from flightstack.training.policy.metrics import measure_policy

RNG = np.random.default_rng(0)


def test_one_gaussian_that_tells_the_truth_covers_ninety_percent() -> None:
    mean = RNG.normal(0.0, 1.0, (1, 20_000, 4))
    target = mean[0] + RNG.normal(0.0, 0.5, (20_000, 4))
    metrics = measure_policy(
        mean, np.full(mean.shape, 0.25), target, members=1, constant=np.zeros(4)
    )
    assert metrics.coverage == pytest.approx([0.9] * 4, abs=0.01)
    assert metrics.rmse == pytest.approx([0.5] * 4, rel=0.02)
    expected = -norm.logpdf(target, mean[0], 0.5).mean(axis=0)
    np.testing.assert_allclose(metrics.nll, expected)


def test_mixture_is_more_than_its_moments() -> None:
    """Two sharp Gaussians at -1 and 1: one Gaussian of their moments would lose 4 nats."""
    modes = np.repeat([-1.0, 1.0], 10_000)[:, np.newaxis]
    on_one = modes + RNG.normal(0.0, 0.01, (20_000, 4))
    mean = np.broadcast_to([[[-1.0]], [[1.0]]], (2, 20_000, 4))
    var = np.full(mean.shape, 1e-4)
    metrics = measure_policy(mean, var, on_one, members=2, constant=np.zeros(4))
    assert metrics.variance_factor == (1.0,) * 4
    expected = np.log(2.0) - np.mean(norm.logpdf(on_one, modes, 0.01), axis=0)
    assert metrics.nll == pytest.approx(expected)
    assert metrics.policy_std[0] == pytest.approx(1.0)
    assert metrics.latent_std[0] == 0.0


def test_line_names_every_velocity() -> None:
    metrics = measure_policy(
        np.zeros((1, 5, 4)), np.ones((1, 5, 4)), np.ones((5, 4)), members=1, constant=np.zeros(4)
    )
    for name in ("vx", "vy", "vz", "yaw_rate"):
        assert f"{name} 1.000" in metrics.line()


def test_recalibration_finds_the_factor_and_leaves_good_intervals_alone() -> None:
    mean = RNG.normal(0.0, 1.0, (1, 20_000, 4))
    target = mean[0] + RNG.normal(0.0, 0.5, (20_000, 4))
    claimed = np.array([0.25, 1.0, 0.04, 0.27])  # variances; the truth is 0.25
    metrics = measure_policy(
        mean,
        np.broadcast_to(claimed, mean.shape),
        target,
        members=1,
        constant=np.zeros(4),
    )
    assert metrics.variance_factor == pytest.approx([1.0, 0.25, 6.25, 1.0], rel=0.05)
    assert metrics.coverage == pytest.approx([0.9] * 4, abs=0.02)
    assert metrics.coverage_before[2] < 0.6


def test_best_member_is_the_one_of_least_nll() -> None:
    target = RNG.normal(0.0, 1.0, (500, 4))
    off = np.array([[0.0, 1.0, 2.0, 0.0], [1.0, 0.0, 1.0, 1.0], [2.0, 2.0, 0.0, 3.0]])
    mean = target + off[:, np.newaxis]
    metrics = measure_policy(mean, np.ones(mean.shape), target, members=3, constant=np.zeros(4))
    assert metrics.best_member == (0, 1, 2, 0)
