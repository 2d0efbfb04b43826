"""Samples of the latent posterior q(z | x, D): what perception says, and how sure it is.

All chance is drawn here, by one generator of numpy's, from the seed: masks first, then noise.

References:
    Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation", eq. 1.
    Gal and Ghahramani 2016, "Dropout as a Bayesian approximation".
"""

from typing import Protocol, runtime_checkable

import numpy as np

from flightstack.arrays import Latents, SmallRgb
from flightstack.perception.config import FEATURES, PerceptionConfig
from flightstack.perception.encoder import Encoder, Noise


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
        self, encoder: Encoder, rng: np.random.Generator, *, samples: int, within: bool = True
    ) -> None:
        self._encoder, self._rng = encoder, rng
        self._samples, self._within = samples, within
        self._kept_weight = np.float32(1.0 / (1.0 - encoder.dropout))

    def sample(self, rgb: SmallRgb) -> Latents:
        """Draw M masks, then M latent samples."""
        drawn = self._rng.random((self._samples, FEATURES), dtype=np.float32)
        masks = (drawn >= self._encoder.dropout) * self._kept_weight
        noise = _noise(self._rng, self._samples, self._encoder)
        return self._encoder.sample(rgb, masks, noise if self._within else np.zeros_like(noise))


class GaussianPosterior:
    """M draws from N(mu, sigma^2) of one deterministic pass."""

    def __init__(self, encoder: Encoder, rng: np.random.Generator, *, samples: int) -> None:
        self._encoder, self._rng = encoder, rng
        self._samples = samples

    def sample(self, rgb: SmallRgb) -> Latents:
        """Draw M latent samples."""
        mean, logvar = self._encoder.moments(rgb)
        z: Latents = mean + _noise(self._rng, self._samples, self._encoder) * np.exp(0.5 * logvar)
        return z


class MeanPosterior:
    """The latent mean alone: one sample, no chance."""

    def __init__(self, encoder: Encoder) -> None:
        self._encoder = encoder

    def sample(self, rgb: SmallRgb) -> Latents:
        """Give the mean as one sample."""
        mean, _ = self._encoder.moments(rgb)
        return mean


def make_posterior(config: PerceptionConfig, encoder: Encoder, *, seed: int) -> LatentPosterior:
    """Sample an encoder as its configuration says, all chance from the seed."""
    rng = np.random.default_rng(seed)
    match config.sampling:
        case "mc-dropout":
            return McDropoutPosterior(encoder, rng, samples=config.samples, within=config.within)
        case "gaussian":
            return GaussianPosterior(encoder, rng, samples=config.samples)
        case "mean":
            return MeanPosterior(encoder)


def _noise(rng: np.random.Generator, samples: int, encoder: Encoder) -> Noise:
    return rng.standard_normal((samples, encoder.latent_dims), dtype=np.float32)
