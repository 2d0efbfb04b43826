"""Samples of the latent posterior q(z | x, D): what perception says, and how sure it is.

Only the head differs between passes with different dropout masks, so the trunk runs once an image:
the same samples in distribution as M full passes, at a fraction of the time.

References:
    Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation", eq. 1.
    Gal and Ghahramani 2016 (see dronet.py).
"""

from typing import Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Float32
from torch import Generator, Tensor

from flightstack.arrays import Latents, SmallRgb
from flightstack.perception.cmvae import sample_normal
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.dronet import FEATURES, Dronet
from flightstack.perception.flight_trunk import FlightTrunk
from flightstack.perception.preprocessing import network_input


@runtime_checkable
class LatentPosterior(Protocol):
    """Anything that turns an image into latent samples, by a chance of its own."""

    def sample(self, rgb: SmallRgb) -> Latents:
        """Map one image to M latent samples."""
        ...


class McDropoutPosterior:
    """M passes of the head, each under its own dropout mask (eq. 1).

    Each pass draws the encoder's weights by its mask, and then z ~ N(mu_m, sigma_m^2). With
    `within=False` it takes z = mu_m instead, so that only the encoder's own uncertainty remains.
    """

    def __init__(
        self, encoder: Dronet, generator: Generator, *, samples: int, within: bool = True
    ) -> None:
        self._encoder, self._generator = encoder.eval(), generator
        self._trunk = FlightTrunk(encoder.trunk)
        self._samples, self._within = samples, within

    def sample(self, rgb: SmallRgb) -> Latents:
        """Draw M masks, then M latent samples."""
        with torch.inference_mode():
            features = self._trunk(network_input(rgb[np.newaxis]))  # (1, 512)
            rate, shape = self._encoder.dropout, (self._samples, FEATURES)
            kept = torch.rand(shape, generator=self._generator) >= rate  # as dropout_mask does
            mean, logvar = self._encoder.head(features * (1.0 / (1.0 - rate)) * kept)
            z = sample_normal(mean, logvar, self._generator) if self._within else mean
            return _array(z)


class GaussianPosterior:
    """M draws from N(mu, sigma^2) of one deterministic pass."""

    def __init__(self, encoder: Dronet, generator: Generator, *, samples: int) -> None:
        self._encoder, self._generator = encoder.eval(), generator
        self._samples = samples

    def sample(self, rgb: SmallRgb) -> Latents:
        """Draw M latent samples."""
        with torch.inference_mode():
            mean, logvar = self._encoder(network_input(rgb[np.newaxis]))
            shape = (self._samples, -1)
            return _array(sample_normal(mean.expand(shape), logvar.expand(shape), self._generator))


class MeanPosterior:
    """The latent mean alone: one sample, no chance."""

    def __init__(self, encoder: Dronet) -> None:
        self._encoder = encoder.eval()

    def sample(self, rgb: SmallRgb) -> Latents:
        """Give the mean as one sample."""
        with torch.inference_mode():
            mean, _ = self._encoder(network_input(rgb[np.newaxis]))
            return _array(mean)


def make_posterior(config: PerceptionConfig, encoder: Dronet, *, seed: int) -> LatentPosterior:
    """Sample an encoder as its configuration says, all chance from the seed."""
    generator = torch.Generator().manual_seed(seed)
    match config.sampling:
        case "mc-dropout":
            return McDropoutPosterior(
                encoder, generator, samples=config.samples, within=config.within
            )
        case "gaussian":
            return GaussianPosterior(encoder, generator, samples=config.samples)
        case "mean":
            return MeanPosterior(encoder)


def _array(z: Float32[Tensor, "M Z"]) -> Latents:
    array: Latents = z.numpy()
    return array
