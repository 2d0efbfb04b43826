"""The whole idea on one page: an image becomes a command, and what is known about its doubt.

    image --> M latent samples --> N x M Gaussians over each velocity --> one command
              perception           policy                                 decision

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation".
"""

from dataclasses import replace

from flightstack import models
from flightstack.decision.strategies import Strategy, make_strategy
from flightstack.perception.posterior import LatentPosterior, make_posterior
from flightstack.perception.preprocessing import fit_image
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.policy.scales import VelocityRange
from flightstack.records import Decision, Frame


class Pipeline:
    """Decide one command for every frame; not safe to share between threads.

    Decisions are a pure function of the frames so far and the posterior's seed.
    """

    def __init__(
        self,
        posterior: LatentPosterior,
        ensemble: PolicyEnsemble,
        strategy: Strategy,
        limits: VelocityRange,
    ) -> None:
        self._posterior, self._ensemble, self._strategy = posterior, ensemble, strategy
        self._limits = limits

    def decide(self, frame: Frame) -> Decision:
        """See, predict, decide; the command stays inside the limits."""
        z = self._posterior.sample(fit_image(frame.rgb))
        samples = self._ensemble.predict(z)
        decision = self._strategy.decide(samples)
        return replace(decision, command=self._limits.clip(decision.command))


def load_pipeline(
    model: str, strategy: str | None = None, seed: int = 0, *, direction: str = "cw"
) -> Pipeline:
    """Load a model by name, with its own strategy or another, ready for its first frame.

    `direction` is the course's, "cw" or "ccw", seen from above. Raises ModelError for the model,
    UsageError for the strategy.
    """
    loaded = models.load(model)
    config = loaded.config
    return Pipeline(
        make_posterior(config.perception, loaded.encoder, seed=seed),
        PolicyEnsemble(loaded.policies, config.policy.velocity_range),
        make_strategy(strategy or config.strategy, direction=direction),
        config.policy.velocity_range,
    )
