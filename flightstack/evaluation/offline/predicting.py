"""Let a model look at many images, exactly as it does in flight, and keep all that it says."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flightstack.decision.strategies import Strategy, make_strategy
from flightstack.models import Model
from flightstack.perception.posterior import make_posterior
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.records import ActionSamples, Decision

PARTS = ("aleatoric", "epistemic", "perceptual", "total")


class Predictor:
    """A model's perception and policies, ready for images one by one."""

    def __init__(self, model: Model, *, seed: int) -> None:
        config = model.config
        self._posterior = make_posterior(config.perception, model.encoder, seed=seed)
        limits = config.policy.velocity_range
        self._ensemble = PolicyEnsemble(model.policies, limits, config.policy.variance_factor)

    def latents(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Draw latent samples (M, Z) of one image (64, 64, 3)."""
        return self._posterior.sample(rgb)

    def predict(self, z: NDArray[np.float32]) -> ActionSamples:
        """Predict N x M Gaussians from latent samples."""
        return self._ensemble.predict(z)


@dataclass(frozen=True, slots=True, kw_only=True)
class Predictions:
    """What a model says of K images."""

    mean: NDArray[np.float64]  # (K, N M, 4) m/s, rad/s
    var: NDArray[np.float64]  # (K, N M, 4)
    uncertainty: NDArray[np.float64]  # (K, len(PARTS), 4) standard deviations
    modes: NDArray[np.int64]  # (K, 4) of the pool's means
    de_mean: NDArray[np.float64]  # (K, 4) commands
    mi_mode: NDArray[np.float64]  # (K, 4)

    @classmethod
    def of(cls, model: Model, images: NDArray[np.uint8], *, seed: int) -> Self:
        """Look at images (K, 64, 64, 3) one after another."""
        predictor = Predictor(model, seed=seed)
        samples = [predictor.predict(predictor.latents(rgb)) for rgb in images]
        pooled = _decide(make_strategy("de-mean"), samples)
        chosen = _decide(make_strategy("mi-mode"), samples)
        return cls(
            mean=np.stack([s.mean.reshape(-1, s.mean.shape[2]) for s in samples]),
            var=np.stack([s.var.reshape(-1, s.var.shape[2]) for s in samples]),
            uncertainty=np.stack([_uncertainty(decision) for decision in pooled]),
            modes=np.stack([decision.modes for decision in pooled]),
            de_mean=np.stack([decision.command for decision in pooled]),
            mi_mode=np.stack([decision.command for decision in chosen]),
        )


def _decide(strategy: Strategy, samples: list[ActionSamples]) -> list[Decision]:
    return [strategy.decide(one) for one in samples]


def _uncertainty(decision: Decision) -> NDArray[np.float64]:
    """Each of PARTS for each velocity: (len(PARTS), 4)."""
    parts = np.stack([decision.aleatoric_std, decision.epistemic_std, decision.perceptual_std])
    return np.concatenate([parts, np.sqrt(np.square(parts).sum(axis=0, keepdims=True))])
