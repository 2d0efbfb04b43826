"""The whole idea on one page: an image becomes a command, and how uncertain it is.

    image --> M latent samples --> N x M Gaussians over each velocity --> one command
              perception           policy                                 decision

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation".
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flightstack import extensions, models
from flightstack.companion.piloting.check import check_latents, check_samples, fault_of
from flightstack.companion.piloting.failure import (
    PERCEPTION,
    POLICY,
    STRATEGY,
    PartError,
    PartMarker,
)
from flightstack.decision.strategies import STRATEGIES, Strategy, make_strategy
from flightstack.models import Model
from flightstack.perception.posterior import LatentPosterior, make_posterior
from flightstack.perception.preprocessing import fit_image
from flightstack.policy.ensemble import Policy, PolicyEnsemble
from flightstack.policy.scales import VelocityRange
from flightstack.records import VELOCITIES, Decision, Image

LIMITED = (len(VELOCITIES),)  # the shape of what the limits can be put on


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
        marker: PartMarker | None = None,
    ) -> None:
        self._posterior, self._ensemble, self._strategy = posterior, ensemble, strategy
        self._limits = limits
        self._mark = (PartMarker() if marker is None else marker).mark

    def decide(self, image: Image) -> Decision:
        """See, predict, decide; the command stays inside the limits."""
        self._mark(PERCEPTION)
        z = self._posterior.sample(fit_image(image.rgb))
        check_latents(z)
        self._mark(POLICY)
        samples = self._ensemble.predict(z)
        check_samples(samples)
        self._mark(STRATEGY)
        decision = self._strategy.decide(samples)
        if not isinstance(decision, Decision) or np.shape(decision.command) != LIMITED:
            raise PartError(fault_of(decision) or "gave no command")
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
    load = pipeline_loader(
        model, strategy, seed, direction=direction, perception=perception, policy=policy
    )
    return load(PartMarker())()


def pipeline_loader(
    model: str,
    strategy: str | None = None,
    seed: int = 0,
    *,
    direction: str = "cw",
    perception: str | None = None,
    policy: str | None = None,
) -> Callable[[PartMarker], Callable[[], Pipeline]]:
    """Return what loads a model once, then makes any number of equal pipelines with it.

    Options and errors are those of `load_pipeline`, raised when it loads and when it makes.
    """

    def load(marker: PartMarker) -> Callable[[], Pipeline]:
        loaded = models.load(model)

        def make() -> Pipeline:
            marker.mark(PERCEPTION)
            posterior = _posterior(loaded, perception, seed)
            marker.mark(POLICY)
            ensemble = _policy(loaded, policy, seed)
            marker.mark(STRATEGY)
            decides = _strategy(loaded, strategy, direction, seed)
            return Pipeline(posterior, ensemble, decides, _limits(loaded), marker)

        return make

    return load


def brings_parts(strategy: str | None, perception: str | None, policy: str | None) -> bool:
    """Whether any part is a user's own code."""
    if perception is not None or policy is not None:
        return True
    return strategy is not None and _is_brought(strategy)


def _limits(model: Model) -> VelocityRange:
    return model.config.policy.velocity_range


def _is_brought(strategy: str) -> bool:
    return strategy not in STRATEGIES and extensions.is_extension(extensions.STRATEGY, strategy)


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
    elif _is_brought(name):
        brought: Strategy = extensions.make(
            extensions.STRATEGY, name, direction=direction, seed=seed
        )
        return brought
    best = model.config.policy.best_member
    return make_strategy(name, direction=direction, seed=seed, best_member=best)
