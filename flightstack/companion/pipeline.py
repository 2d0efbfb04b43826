"""The whole idea on one page: an image becomes a command, and how uncertain it is.

    image --> M latent samples --> N x M Gaussians over each velocity --> one command
              perception           policy                                 decision

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation".
"""

from dataclasses import replace

from flightstack import extensions, models
from flightstack.decision.strategies import STRATEGIES, Strategy, make_strategy
from flightstack.models import Model
from flightstack.perception.posterior import LatentPosterior, make_posterior
from flightstack.perception.preprocessing import fit_image
from flightstack.policy.ensemble import Policy, PolicyEnsemble
from flightstack.policy.scales import VelocityRange
from flightstack.records import Decision, Image


class Pipeline:
    """Decide one command for every image; not safe to share between threads.

    Decisions are a pure function of the images so far and the posterior's seed.
    """

    def __init__(
        self,
        posterior: LatentPosterior,
        ensemble: Policy,
        strategy: Strategy,
        limits: VelocityRange,
    ) -> None:
        self._posterior, self._ensemble, self._strategy = posterior, ensemble, strategy
        self._limits = limits

    def decide(self, image: Image) -> Decision:
        """See, predict, decide; the command stays inside the limits."""
        z = self._posterior.sample(fit_image(image.rgb))
        samples = self._ensemble.predict(z)
        decision = self._strategy.decide(samples)
        return replace(decision, command=self._limits.clip(decision.command))


def load_pipeline(
    model: str,
    strategy: str | None = None,
    seed: int = 0,
    *,
    direction: str = "cw",
    perception: str | None = None,
    policy: str | None = None,
) -> Pipeline:
    """Load a model by name, with its own parts or with others, ready for its first image.

    `direction` is the course's, "cw" or "ccw", seen from above. `strategy`, `perception` and
    `policy` may name what a user brings (docs/bring-your-own.md). Raises ModelError for the model,
    UsageError for the parts.
    """
    loaded = models.load(model)
    limits = loaded.config.policy.velocity_range
    return Pipeline(
        _posterior(loaded, perception, seed),
        _policy(loaded, policy, seed),
        _strategy(loaded, strategy, direction, seed),
        limits,
    )


def _posterior(model: Model, name: str | None, seed: int) -> LatentPosterior:
    if name is None:
        return make_posterior(model.config.perception, model.encoder, seed=seed)
    brought: LatentPosterior = extensions.make(extensions.PERCEPTION, name, model=model, seed=seed)
    return brought


def _policy(model: Model, name: str | None, seed: int) -> Policy:
    config = model.config.policy
    if name is None:
        return PolicyEnsemble(model.policies, config.velocity_range, config.variance_factor)
    brought: Policy = extensions.make(extensions.POLICY, name, model=model, seed=seed)
    return brought


def _strategy(model: Model, name: str | None, direction: str, seed: int) -> Strategy:
    if name is None:  # the model's own: a part of flightstack, and never code
        name = model.config.strategy
    elif name not in STRATEGIES and extensions.is_extension(extensions.STRATEGY, name):
        brought: Strategy = extensions.make(
            extensions.STRATEGY, name, direction=direction, seed=seed
        )
        return brought
    best = model.config.policy.best_member
    return make_strategy(name, direction=direction, seed=seed, best_member=best)
