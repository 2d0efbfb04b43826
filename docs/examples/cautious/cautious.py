"""Three parts of one's own: a strategy, a perception and a policy, each a few lines."""

from dataclasses import replace

import numpy as np

from flightstack.arrays import Latents, SmallRgb
from flightstack.decision.strategies import make_strategy
from flightstack.models import Model
from flightstack.perception.posterior import make_posterior
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.records import ActionSamples, Decision

HALVING_STD = np.array([1.0, 0.6, 0.6, 0.4])  # m/s, m/s, m/s, rad/s; at one of them half the speed


class CautiousStrategy:
    """Fly the mean, and slower the more all parts of the uncertainty add up to."""

    def __init__(self, *, direction: str, seed: int) -> None:
        self._mean = make_strategy("de-mean", direction=direction, seed=seed)

    def decide(self, samples: ActionSamples) -> Decision:
        """Decide one command from N x M Gaussians."""
        decision = self._mean.decide(samples)
        total_std = np.sqrt(
            decision.aleatoric_std**2 + decision.epistemic_std**2 + decision.perceptual_std**2
        )
        command = decision.command.copy()
        command[0] *= 1.0 / (1.0 + np.max(total_std / HALVING_STD))
        return replace(decision, command=command)


class SteadyPerception:
    """The model's own latent samples, pooled over the last two images."""

    def __init__(self, *, model: Model, seed: int) -> None:
        self._posterior = make_posterior(model.config.perception, model.encoder, seed=seed)
        self._last: Latents | None = None

    def sample(self, rgb: SmallRgb) -> Latents:
        """Map one image to latent samples."""
        now = self._posterior.sample(rgb)
        before = now if self._last is None else self._last
        self._last = now
        return np.concatenate([now, before])


class HumblePolicy:
    """The model's own predictions with twice their variance."""

    def __init__(self, *, model: Model, seed: int) -> None:  # noqa: ARG002  no chance in it
        config = model.config.policy
        self._ensemble = PolicyEnsemble(
            model.policies, config.velocity_range, config.variance_factor
        )

    def predict(self, z: Latents) -> ActionSamples:
        """Map latents to means and variances."""
        samples = self._ensemble.predict(z)
        return ActionSamples(mean=samples.mean, var=2.0 * samples.var)
