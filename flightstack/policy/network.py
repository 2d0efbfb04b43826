"""N policy networks as one: their weights stacked, their passes one batched matrix product.

Each is a small perceptron Z-256-64-(4|8). A probabilistic one predicts the mean and log-variance of
every velocity, a deterministic one the mean alone.

References:
    Lakshminarayanan et al. 2017, "Simple and scalable predictive uncertainty estimation using deep
    ensembles"; Kendall and Gal 2017, "What uncertainties do we need": the loss.
"""

import math

import torch
from torch import Generator, Tensor, nn

from flightstack.policy.config import PolicyConfig
from flightstack.records import VELOCITIES

LOGVAR_MIDDLE, LOGVAR_HALF = -5.0, 5.0  # network units: sigma from 0.7 % to 100 % of half the range


class StackedLinear(nn.Module):
    """N dense layers side by side: (N, B, I) or (B, I) to (N, B, O)."""

    def __init__(self, members: int, inputs: int, outputs: int, generator: Generator) -> None:
        super().__init__()
        bound = 1.0 / math.sqrt(inputs)  # torch's own initialisation of a dense layer
        self.weight = _uniform((members, inputs, outputs), bound, generator)
        self.bias = _uniform((members, 1, outputs), bound, generator)

    def forward(self, x: Tensor) -> Tensor:
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
        outputs = len(VELOCITIES) * (2 if config.probabilistic else 1)
        self.dense1 = StackedLinear(members, latent_dims, hidden[0], generator)
        self.dense2 = StackedLinear(members, hidden[0], hidden[1], generator)
        self.out = StackedLinear(members, hidden[1], outputs, generator)
        self.latent_mean: Tensor
        self.latent_std: Tensor
        self.register_buffer("latent_mean", torch.zeros(latent_dims))
        self.register_buffer("latent_std", torch.ones(latent_dims))

    def forward(self, z: Tensor) -> tuple[Tensor, Tensor]:
        """Map latents (N, B, Z) or (B, Z) to mean and log-variance, each (N, B, 4).

        A deterministic policy claims the smallest log-variance that a probabilistic one can.
        """
        hidden = torch.relu(self.dense1((z - self.latent_mean) / self.latent_std))
        out = self.out(torch.relu(self.dense2(hidden)))
        if not self.probabilistic:
            return out, torch.full_like(out, LOGVAR_MIDDLE - LOGVAR_HALF)
        mean, raw = out[..., : len(VELOCITIES)], out[..., len(VELOCITIES) :]
        return mean, LOGVAR_MIDDLE + LOGVAR_HALF * torch.tanh(raw / LOGVAR_HALF)


def gaussian_nll(mean: Tensor, logvar: Tensor, target: Tensor) -> Tensor:
    """Give the heteroscedastic loss (Kendall and Gal 2017), elementwise, without its constant."""
    return 0.5 * ((target - mean).square() * torch.exp(-logvar) + logvar)


def _uniform(shape: tuple[int, ...], bound: float, generator: Generator) -> nn.Parameter:
    return nn.Parameter(torch.empty(shape).uniform_(-bound, bound, generator=generator))
