import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.special import logsumexp

from flightstack.decision import information
from flightstack.decision.information import gaussian_score, quadrature_score
from flightstack.decision.mixture import pool_mean, split_variance
from flightstack.records import ActionSamples


def make_samples(
    seed: int, members: int = 5, latents: int = 8, apart: float = 1.0
) -> ActionSamples:
    rng = np.random.default_rng(seed)
    shape = (members, latents, 4)
    mean = apart * rng.normal(0.0, 1.0, (members, 1, 4)) + rng.normal(0.0, 0.3, shape)
    return ActionSamples(mean=mean, var=rng.uniform(0.05, 0.5, shape))


def kl_to_matched_gaussian(samples: ActionSamples) -> NDArray[np.float64]:
    """The textbook KL between Gaussians, averaged over each member's latent samples."""
    centre, var = pool_mean(samples), split_variance(samples).total
    own_var, own_mean = samples.var, samples.mean
    kl = 0.5 * (np.log(var / own_var) + (own_var + (own_mean - centre) ** 2) / var - 1.0)
    return np.asarray(kl.mean(axis=1))


def test_gaussian_score_is_the_mean_kl_to_the_matched_gaussian() -> None:
    samples = make_samples(1)
    np.testing.assert_allclose(gaussian_score(samples), kl_to_matched_gaussian(samples), rtol=1e-10)


def test_quadrature_agrees_with_monte_carlo() -> None:
    samples = make_samples(2, members=3, latents=4)
    rng = np.random.default_rng(5)
    std = np.sqrt(samples.var)
    draws = rng.normal(samples.mean, std, (12_000, *samples.mean.shape))  # (D, N, M, 4)

    def log_density(y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Of every component at y (..., 4): (..., N M, 4), without the constant."""
        means, stds = samples.mean.reshape(-1, 4), std.reshape(-1, 4)
        return np.asarray(-0.5 * ((y[..., np.newaxis, :] - means) / stds) ** 2 - np.log(stds))

    own = -0.5 * ((draws - samples.mean) / std) ** 2 - np.log(std)
    pool = logsumexp(log_density(draws), axis=-2) - math.log(12)
    expected = (own - pool).mean(axis=(0, 2))  # 48,000 draws each, of a spread near 1 nat
    np.testing.assert_allclose(quadrature_score(samples), expected, atol=0.02)


def test_few_nodes_agree_with_many(monkeypatch: pytest.MonkeyPatch) -> None:
    samples = make_samples(6, latents=32)
    quick = quadrature_score(samples)
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    monkeypatch.setattr(information, "_NODES", nodes)
    monkeypatch.setattr(information, "_WEIGHTS", weights / weights.sum())
    np.testing.assert_allclose(quick, quadrature_score(samples), atol=0.01)


def test_both_scores_agree_where_the_pool_is_gaussian() -> None:
    rng = np.random.default_rng(3)
    mean = rng.normal(0.0, 1.0, (5, 400, 4))  # the pool of many is close to N(0, 2)
    samples = ActionSamples(mean=mean, var=np.ones_like(mean))
    np.testing.assert_allclose(gaussian_score(samples), quadrature_score(samples), atol=0.03)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32), apart=st.floats(0.0, 50.0))
def test_exact_score_lies_between_0_and_ln_nm(seed: int, apart: float) -> None:
    score = quadrature_score(make_samples(seed, apart=apart))
    assert (score > -0.02).all()  # the quadrature's own error
    assert (score < math.log(5 * 8) + 0.02).all()


def test_bound_is_reached_by_predictions_far_apart() -> None:
    mean = np.arange(6.0).reshape(2, 3, 1).repeat(4, axis=2) * 1000.0
    samples = ActionSamples(mean=mean, var=np.ones_like(mean))
    assert quadrature_score(samples) == pytest.approx(np.full((2, 4), math.log(6)), abs=1e-3)


def test_one_lone_prediction_says_nothing_beyond_itself() -> None:
    samples = make_samples(4, members=1, latents=1)
    assert gaussian_score(samples) == pytest.approx(np.zeros((1, 4)), abs=1e-12)
    lone = quadrature_score(samples)
    assert lone == pytest.approx(np.zeros((1, 4)), abs=1e-6)  # in single precision
