import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightstack.decision.mixture import pool_mean, split_variance
from flightstack.records import ActionSamples


def make_samples(seed: int, members: int = 5, latents: int = 32) -> ActionSamples:
    rng = np.random.default_rng(seed)
    mean = rng.normal(0.0, 1.0, (members, latents, 4)) + rng.normal(0.0, 2.0, (members, 1, 4))
    return ActionSamples(mean=mean, var=rng.uniform(0.01, 2.0, (members, latents, 4)))


@given(seed=st.integers(0, 2**32), members=st.integers(1, 6), latents=st.integers(1, 40))
def test_parts_add_up_to_the_pools_variance(seed: int, members: int, latents: int) -> None:
    samples = make_samples(seed, members, latents)
    second_moment = (samples.var + samples.mean**2).mean(axis=(0, 1))
    expected = second_moment - pool_mean(samples) ** 2
    np.testing.assert_allclose(split_variance(samples).total, expected, rtol=1e-9)


def test_moments_agree_with_monte_carlo() -> None:
    samples = make_samples(7)
    rng = np.random.default_rng(1)
    draws = rng.normal(samples.mean, np.sqrt(samples.var), (20_000, *samples.mean.shape))
    pool = draws.reshape(-1, 4)  # 3.2 million draws: 5 standard errors are below 0.7 %
    np.testing.assert_allclose(pool.mean(axis=0), pool_mean(samples), atol=0.01)
    np.testing.assert_allclose(pool.var(axis=0), split_variance(samples).total, rtol=0.007)


def test_members_that_agree_leave_no_policy_part() -> None:
    one = make_samples(3, members=1)
    same = ActionSamples(mean=one.mean.repeat(4, axis=0), var=one.var.repeat(4, axis=0))
    parts = split_variance(same)
    np.testing.assert_allclose(parts.policy, 0.0, atol=1e-28)
    np.testing.assert_allclose(parts.latent, one.mean[0].var(axis=0))


def test_one_latent_sample_leaves_no_latent_part() -> None:
    assert split_variance(make_samples(3, latents=1)).latent == pytest.approx(np.zeros(4))
