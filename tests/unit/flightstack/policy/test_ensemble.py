from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from flightstack.networks.policy_stack import PolicyStack
from flightstack.policy.config import PolicyConfig
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.policy.networks import PolicyNetworks
from flightstack.policy.scales import VelocityRange
from tests.unit.flightstack.exported import flown_policies

RNG = np.random.default_rng(0)


def make_stack(config: PolicyConfig) -> PolicyStack:
    stack = PolicyStack(config, latent_dims=10, generator=torch.Generator().manual_seed(0))
    stack.latent_mean.fill_(0.5)
    stack.latent_std.fill_(2.0)
    return stack.eval()


ENSEMBLE = PolicyConfig(members=5, probabilistic=True)


@pytest.fixture(scope="module")
def networks(tmp_path_factory: pytest.TempPathFactory) -> PolicyNetworks:
    return flown_policies(tmp_path_factory.mktemp("policies"), make_stack(ENSEMBLE), ENSEMBLE)


def test_ensemble_speaks_in_metres_and_radians_per_second(networks: PolicyNetworks) -> None:
    z = RNG.normal(size=(32, 10)).astype(np.float32)
    samples = PolicyEnsemble(networks, VelocityRange()).predict(z)
    with torch.inference_mode():
        mean, logvar = (part.numpy() for part in make_stack(ENSEMBLE)(torch.from_numpy(z)))
    assert samples.mean.shape == samples.var.shape == (5, 32, 4)
    np.testing.assert_allclose(samples.mean[..., 0], 3.0 + 4.0 * mean[..., 0], rtol=1e-5)
    np.testing.assert_allclose(samples.var[..., 3], np.exp(logvar[..., 3]), rtol=1e-5)
    np.testing.assert_allclose(samples.var[..., 0], 16.0 * np.exp(logvar[..., 0]), rtol=1e-5)


def test_deterministic_policy_claims_the_least_variance(tmp_path: Path) -> None:
    config = PolicyConfig(members=1, probabilistic=False)
    networks = flown_policies(tmp_path, make_stack(config), config)
    samples = PolicyEnsemble(networks, VelocityRange()).predict(np.zeros((32, 10), np.float32))
    least = np.exp(-10.0) * np.array([16.0, 9.0, 9.0, 1.0])
    np.testing.assert_allclose(samples.var, np.broadcast_to(least, (1, 32, 4)), rtol=1e-6)


def test_a_mixtures_samples_follow_its_heads_however_many_there_are(tmp_path: Path) -> None:
    config = PolicyConfig(members=2, probabilistic=True, mixture=3)
    stack = make_stack(config)
    networks = flown_policies(tmp_path, stack, config)
    for samples in (1, 8, 40):  # other than what was traced
        z = RNG.normal(size=(samples, 10)).astype(np.float32)
        with torch.inference_mode():
            mean, _ = stack(torch.from_numpy(z))
        np.testing.assert_allclose(networks.moments(z).mean, mean.numpy(), atol=1e-5)


def test_recalibration_scales_the_variance_alone(networks: PolicyNetworks) -> None:
    z = RNG.normal(0.0, 1.0, (4, 10)).astype(np.float32)
    plain = PolicyEnsemble(networks, VelocityRange()).predict(z)
    scaled = PolicyEnsemble(networks, VelocityRange(), (2.0, 1.0, 0.5, 1.0)).predict(z)
    np.testing.assert_allclose(scaled.var, plain.var * [2.0, 1.0, 0.5, 1.0])
    np.testing.assert_array_equal(scaled.mean, plain.mean)


def test_range_maps_its_ends_to_one_and_clips_beyond() -> None:
    limits = VelocityRange()
    ends = np.array([limits.low, limits.high], dtype=np.float32)
    np.testing.assert_allclose(limits.encode(ends), [[-1.0] * 4, [1.0] * 4], atol=1e-6)
    assert limits.clip(np.array([9.0, -4.0, 0.5, 2.0])).tolist() == [7.0, -3.0, 0.5, 1.0]


def test_range_upside_down_is_refused() -> None:
    with pytest.raises(ValueError, match="must lie below"):
        VelocityRange(low=(1.0, 0.0, 0.0, 0.0), high=(0.0, 1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mixture": 0}, "mixture must be at least 1"),
        ({"mixture": 2, "probabilistic": False}, "1 where not probabilistic"),
        ({"variance_factor": (1.0, 0.0, 1.0, 1.0)}, "variance_factor needs 4 positive"),
        ({"best_member": (0, 1, 2, 5)}, "best_member needs 4 of the members"),
    ],
)
def test_policies_that_cannot_be_are_refused(values: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PolicyConfig(**{"members": 5, "probabilistic": True, **values})
