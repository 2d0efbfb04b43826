"""The encoder as it flies: an image, masks and noise to latent samples.

Only what stands after the dropout slot differs between passes with different masks, so what stands
before it runs once an image: the same samples as that many full passes, at a fraction of the time.
"""

from pathlib import Path

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import Latents, SmallRgb
from flightstack.inference.graph import Graph, Signature
from flightstack.perception.config import FEATURES, PerceptionConfig

Masks = Float32[NDArray[np.float32], "P 512"]  # of P passes: 0, or what keeps the mean
Noise = Float32[NDArray[np.float32], "P Z"]

ENCODER_FILE = "encoder.onnx"
RGB, MASKS, NOISE, SAMPLES, MEAN, LOGVAR = "rgb", "masks", "noise", "z", "mean", "logvar"
UNMASKED: Masks = np.ones((1, FEATURES), np.float32)


def encoder_signature(latent_dims: int) -> Signature:
    """Return what an encoder with Z latent dimensions takes and gives."""
    per_pass = (None, latent_dims)
    return Signature(
        inputs={RGB: (1, 64, 64, 3), MASKS: (None, FEATURES), NOISE: per_pass},
        outputs={SAMPLES: per_pass, MEAN: per_pass, LOGVAR: per_pass},
    )


class Encoder:
    """Image to latents; a pure function of the image, the masks and the noise."""

    def __init__(self, folder: Path, config: PerceptionConfig, *, sha256: str) -> None:
        """Load it from a model's folder; raises ModelError."""
        self.latent_dims, self.dropout = config.latent_dims, config.dropout
        signature = encoder_signature(config.latent_dims)
        self._graph = Graph(folder / ENCODER_FILE, sha256=sha256, signature=signature)

    def sample(self, rgb: SmallRgb, masks: Masks, noise: Noise) -> Latents:
        """Return z = mean + noise x deviation, one of each pass."""
        (z,) = self._graph.run([SAMPLES], {RGB: rgb[None], MASKS: masks, NOISE: noise})
        return z

    def moments(self, rgb: SmallRgb) -> tuple[Latents, Latents]:
        """Return mean and log-variance of one pass without dropout, (1, Z) each."""
        noise = np.zeros((1, self.latent_dims), np.float32)
        mean, logvar = self._graph.run(
            [MEAN, LOGVAR], {RGB: rgb[None], MASKS: UNMASKED, NOISE: noise}
        )
        return mean, logvar
