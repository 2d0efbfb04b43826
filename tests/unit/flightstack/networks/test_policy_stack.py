import math

import pytest
import torch
from torch.distributions import Normal

from flightstack.networks.policy_stack import PolicyStack, gaussian_nll, mixture_nll
from flightstack.policy.config import PolicyConfig


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
