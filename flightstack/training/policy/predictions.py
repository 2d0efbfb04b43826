"""Predict the velocities of many images at once: every member, over several latent samples."""

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Generator

from flightstack.arrays import PerComponent
from flightstack.networks.policy_stack import GOLDEN, PolicyStack
from flightstack.policy.scales import VelocityRange
from flightstack.training.perception.latents import LatentSource

SAMPLES = 32  # latent samples of each image


def predict(
    stack: PolicyStack,
    latents: LatentSource,
    velocity_range: VelocityRange,
    at: NDArray[np.int64],
    *,
    generator: Generator,
    samples: int = SAMPLES,
) -> tuple[PerComponent, PerComponent]:
    """Means and variances in m/s and rad/s for the images at `at`, member by member."""
    rows = torch.from_numpy(at).to(latents.features.device)
    means, variances = [], []
    with torch.inference_mode():
        start = torch.rand(len(at), generator=generator, device=rows.device)
        for k in range(samples):
            quantile = (start + k * GOLDEN) % 1.0
            mean, logvar = stack(latents.draw(generator)[rows], quantile)
            means.append(mean.cpu().numpy())
            variances.append(np.exp(logvar.cpu().numpy()))
    mean = components(means, axis=1) * velocity_range.scale + velocity_range.offset
    return mean, components(variances, axis=1) * velocity_range.scale**2


def components(
    parts: list[NDArray[np.float32]] | list[NDArray[np.float64]], *, axis: int
) -> PerComponent:
    """Join M arrays (N, K, 4) in axis 1, or K of (N, M, 4) in axis 2, to (N M, K, 4)."""
    joined = np.stack(parts, axis=axis).astype(np.float64)  # (N, M, K, 4)
    return joined.reshape(-1, *joined.shape[2:])
