"""N policy networks as one: their weights stacked, their passes one batched matrix product.

Each is a small perceptron Z-256-64-(4|8). A probabilistic one predicts the mean and log-variance of
every velocity, a deterministic one the mean alone. With mixture heads each predicts several such
Gaussians and their weights, the same weights for all velocities: "left or right" is one question.

References:
    Bishop 1994, "Mixture density networks".
    Lakshminarayanan et al. 2017, "Simple and scalable predictive uncertainty estimation using deep
    ensembles"; Kendall and Gal 2017, "What uncertainties do we need": the loss.
"""

import math
from typing import NamedTuple

import torch
from jaxtyping import Float
from torch import Generator, Tensor, nn

from flightstack.policy.config import PolicyConfig
from flightstack.records import VELOCITIES

LOGVAR_MIDDLE, LOGVAR_HALF = -5.0, 5.0  # network units: sigma from 0.7 % to 100 % of half the range

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # its multiples, modulo 1, fill the unit interval evenly

VelocityTensor = Float[Tensor, "N B 4"]  # of N members
Alike = Float[Tensor, "*alike"]  # any shape, the same for all that are called so


class Heads(NamedTuple):
    """What N members say of B latents with H heads each, in network units."""

    mean: Float[Tensor, "N B H 4"]
    logvar: Float[Tensor, "N B H 4"]
    logweight: Float[Tensor, "N B H"]


class StackedLinear(nn.Module):
    """N dense layers side by side."""

    def __init__(self, members: int, inputs: int, outputs: int, generator: Generator) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(inputs)  # torch's own initialisation of a dense layer
        self.weight = _uniform((members, inputs, outputs), bound, generator)
        self.bias = _uniform((members, 1, outputs), bound, generator)

    def forward(self, x: Float[Tensor, "*N B I"]) -> Float[Tensor, "N B O"]:
        """Give every member its own input, or the same one to all."""
        members = self.weight.shape[0]
        return torch.baddbmm(self.bias, x.expand(members, *x.shape[-2:]), self.weight)


class PolicyStack(nn.Module):
    """N policies with standardised latents inside; outputs in network units."""

    def __init__(
        self,
        config: PolicyConfig,
        *,
        latent_dims: int,
        generator: Generator,
    ) -> None:
        super().__init__()
        members, hidden = config.members, config.hidden
        self.probabilistic = config.probabilistic
        self.mixture = config.mixture
        outputs = config.mixture * len(VELOCITIES) * (2 if config.probabilistic else 1)
        outputs += config.mixture if config.mixture > 1 else 0
        self.dense1 = StackedLinear(members, latent_dims, hidden[0], generator)
        self.dense2 = StackedLinear(members, hidden[0], hidden[1], generator)
        self.out = StackedLinear(members, hidden[1], outputs, generator)
        self.latent_mean: Tensor
        self.latent_std: Tensor
        self.register_buffer("latent_mean", torch.zeros(latent_dims))
        self.register_buffer("latent_std", torch.ones(latent_dims))

    def forward(
        self, z: Float[Tensor, "*N B Z"], quantile: Float[Tensor, " B"] | None = None
    ) -> tuple[VelocityTensor, VelocityTensor]:
        """Map latents, of each policy or of all, to mean and log-variance.

        A deterministic policy claims the smallest log-variance that a probabilistic one can, until
        it is recalibrated. With mixture heads each latent sample follows one of them, by their
        weights: the one at its `quantile` of the weights' sum; left out, the samples spread
        evenly over [0, 1).
        """
        if self.mixture > 1:
            return self._follow(self.heads(z), quantile)
        out = self._out(z)
        if not self.probabilistic:
            return out, torch.full_like(out, LOGVAR_MIDDLE - LOGVAR_HALF)
        return out[..., : len(VELOCITIES)], _logvar(out[..., len(VELOCITIES) :])

    def heads(self, z: Float[Tensor, "*N B Z"]) -> Heads:
        """Map latents to all heads of a probabilistic policy."""
        out = self._out(z)
        values = self.mixture * len(VELOCITIES)
        shape = (*out.shape[:-1], self.mixture, len(VELOCITIES))
        weights = out[..., 2 * values :] if self.mixture > 1 else out.new_zeros(*out.shape[:-1], 1)
        return Heads(
            mean=out[..., :values].reshape(shape),
            logvar=_logvar(out[..., values : 2 * values].reshape(shape)),
            logweight=torch.log_softmax(weights, dim=-1),
        )

    def _out(self, z: Float[Tensor, "*N B Z"]) -> Float[Tensor, "N B O"]:
        hidden = torch.relu(self.dense1((z - self.latent_mean) / self.latent_std))
        out: Tensor = self.out(torch.relu(self.dense2(hidden)))
        return out

    def _follow(
        self, heads: Heads, quantile: Tensor | None
    ) -> tuple[VelocityTensor, VelocityTensor]:
        if quantile is None:
            steps = torch.arange(heads.mean.shape[1], device=heads.mean.device, dtype=torch.float64)
            quantile = ((steps + 0.5) * GOLDEN % 1.0).to(heads.mean.dtype)
        reached = heads.logweight.exp().cumsum(dim=-1) < quantile[:, None]  # (N, B, H)
        chosen = reached.sum(dim=-1).clamp(max=self.mixture - 1)
        index = chosen[..., None, None].expand(*chosen.shape, 1, len(VELOCITIES))
        mean, logvar = (part.gather(2, index).squeeze(2) for part in heads[:2])
        return mean, logvar


def mixture_nll(heads: Heads, target: VelocityTensor) -> Float[Tensor, "N B"]:
    """Give the loss of mixture heads, all velocities together, without its constant."""
    nll = gaussian_nll(heads.mean, heads.logvar, target[..., None, :]).sum(dim=-1)
    return -torch.logsumexp(heads.logweight - nll, dim=-1)


def gaussian_nll(mean: Alike, logvar: Alike, target: Float[Tensor, "*#alike"]) -> Alike:
    """Give the heteroscedastic loss (Kendall and Gal 2017), elementwise, without its constant."""
    return 0.5 * ((target - mean).square() * torch.exp(-logvar) + logvar)


def _uniform(shape: tuple[int, ...], bound: float, generator: Generator) -> nn.Parameter:
    return nn.Parameter(torch.empty(shape).uniform_(-bound, bound, generator=generator))


def _logvar(raw: Tensor) -> Tensor:
    return LOGVAR_MIDDLE + LOGVAR_HALF * torch.tanh(raw / LOGVAR_HALF)
