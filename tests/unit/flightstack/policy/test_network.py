import math
from typing import Any

import numpy as np
import pytest
import torch
from torch.distributions import Normal

from flightstack.policy.config import PolicyConfig
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.policy.network import PolicyStack, gaussian_nll, mixture_nll
from flightstack.policy.scales import VelocityRange

RNG = np.random.default_rng(0)


def make_stack(members: int = 5, *, probabilistic: bool = True) -> PolicyStack:
    config = PolicyConfig(members=members, probabilistic=probabilistic)
    stack = PolicyStack(config, latent_dims=10, generator=torch.Generator().manual_seed(0))
    stack.latent_mean.fill_(0.5)
    stack.latent_std.fill_(2.0)
    return stack.eval()


def test_stack_is_its_members_side_by_side() -> None:
    stack, z = make_stack(), torch.randn(32, 10, generator=torch.Generator().manual_seed(1))
    mean, logvar = stack(z)
    for n in range(5):
        hidden = (z - 0.5) / 2.0
        for layer in (stack.dense1, stack.dense2):
            hidden = torch.relu(hidden @ layer.weight[n] + layer.bias[n])
        out = hidden @ stack.out.weight[n] + stack.out.bias[n]
        torch.testing.assert_close(mean[n], out[:, :4], atol=1e-5, rtol=1e-4)
        torch.testing.assert_close(
            logvar[n], -5.0 + 5.0 * torch.tanh(out[:, 4:] / 5.0), atol=1e-5, rtol=1e-4
        )


def test_members_take_their_own_inputs() -> None:
    stack, z = make_stack(2), torch.randn(2, 7, 10, generator=torch.Generator().manual_seed(1))
    own, _ = stack(z)
    for n in range(2):
        torch.testing.assert_close(own[n], stack(z[n])[0][n])


def test_members_start_apart() -> None:
    weight = make_stack().dense1.weight
    assert not torch.equal(weight[0], weight[1])


def test_log_variance_stays_in_bounds_for_absurd_latents() -> None:
    _, logvar = make_stack()(torch.full((3, 10), 1e6))
    assert float(logvar.detach().min()) >= -10.0
    assert float(logvar.detach().max()) <= 0.0


def test_nll_is_torchs_own_up_to_its_constant() -> None:
    mean, logvar, target = torch.randn(3, 8, 4, generator=torch.Generator().manual_seed(0))
    reference = -Normal(mean, torch.exp(0.5 * logvar)).log_prob(target)  # type: ignore[no-untyped-call]  # of torch
    torch.testing.assert_close(
        gaussian_nll(mean, logvar, target) + 0.5 * math.log(2.0 * math.pi), reference
    )


def test_ensemble_speaks_in_metres_and_radians_per_second() -> None:
    stack, limits = make_stack(), VelocityRange()
    z = RNG.normal(size=(32, 10)).astype(np.float32)
    samples = PolicyEnsemble(stack, limits).predict(z)
    mean, logvar = (part.detach().numpy() for part in stack(torch.from_numpy(z)))
    assert samples.mean.shape == samples.var.shape == (5, 32, 4)
    np.testing.assert_allclose(samples.mean[..., 0], 3.0 + 4.0 * mean[..., 0], rtol=1e-5)
    np.testing.assert_allclose(samples.var[..., 3], np.exp(logvar[..., 3]), rtol=1e-5)
    np.testing.assert_allclose(samples.var[..., 0], 16.0 * np.exp(logvar[..., 0]), rtol=1e-5)


def test_deterministic_policy_claims_the_least_variance() -> None:
    samples = PolicyEnsemble(make_stack(1, probabilistic=False), VelocityRange()).predict(
        np.zeros((32, 10), dtype=np.float32)
    )
    np.testing.assert_allclose(
        samples.var, np.broadcast_to(np.exp(-10.0) * np.array([16.0, 9.0, 9.0, 1.0]), (1, 32, 4))
    )


def test_range_maps_its_ends_to_one_and_clips_beyond() -> None:
    limits = VelocityRange()
    ends = np.array([limits.low, limits.high], dtype=np.float32)
    np.testing.assert_allclose(limits.encode(ends), [[-1.0] * 4, [1.0] * 4], atol=1e-6)
    assert limits.clip(np.array([9.0, -4.0, 0.5, 2.0])).tolist() == [7.0, -3.0, 0.5, 1.0]


def test_range_upside_down_is_refused() -> None:
    with pytest.raises(ValueError, match="must lie below"):
        VelocityRange(low=(1.0, 0.0, 0.0, 0.0), high=(0.0, 1.0, 1.0, 1.0))


def test_mixture_heads_are_followed_by_their_weights() -> None:
    config = PolicyConfig(members=2, probabilistic=True, mixture=3)
    stack = PolicyStack(config, latent_dims=10, generator=torch.Generator().manual_seed(0)).eval()
    z = torch.zeros(1000, 10)
    heads = stack.heads(z)
    mean, _ = stack(z)
    for n in range(2):
        shares = [(mean[n] == heads.mean[n, 0, h]).all(dim=1).float().mean() for h in range(3)]
        expected = heads.logweight[n, 0].exp().tolist()
        assert [float(share) for share in shares] == pytest.approx(expected, abs=0.01)


def test_one_head_of_a_mixture_is_the_plain_loss() -> None:
    stack, z = make_stack(), torch.randn(8, 10, generator=torch.Generator().manual_seed(1))
    target = torch.zeros(5, 8, 4)
    mean, logvar = stack(z)
    torch.testing.assert_close(
        mixture_nll(stack.heads(z), target), gaussian_nll(mean, logvar, target).sum(dim=-1)
    )


def test_recalibration_scales_the_variance_alone() -> None:
    stack, z = make_stack(), RNG.normal(0.0, 1.0, (4, 10)).astype(np.float32)
    plain = PolicyEnsemble(stack, VelocityRange()).predict(z)
    scaled = PolicyEnsemble(stack, VelocityRange(), (2.0, 1.0, 0.5, 1.0)).predict(z)
    np.testing.assert_allclose(scaled.var, plain.var * [2.0, 1.0, 0.5, 1.0])
    np.testing.assert_array_equal(scaled.mean, plain.mean)


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
