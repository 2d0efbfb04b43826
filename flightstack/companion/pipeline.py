"""The whole idea on one page: an image becomes a command, and what is known about its doubt.

    image --> M latent samples --> N x M Gaussians over each velocity --> one command
              perception           policy                                 decision

Reference: Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation".
"""

from dataclasses import replace

import numpy as np
import torch

from flightstack import models
from flightstack.decision.strategies import Strategy, make_strategy
from flightstack.perception.posterior import LatentPosterior, make_posterior
from flightstack.perception.preprocessing import IMAGE_SIZE, fit_image
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.policy.scales import VelocityRange
from flightstack.records import Decision, Frame

THREADS = 1  # the networks are too small to share among more
BLANK = np.zeros((IMAGE_SIZE, IMAGE_SIZE, 3), dtype=np.uint8)


class Pipeline:
    """Decide one command for every frame; not safe to share between threads.

    Decisions are a pure function of the frames so far and the seed.
    """

    def __init__(
        self,
        posterior: LatentPosterior,
        ensemble: PolicyEnsemble,
        strategy: Strategy,
        *,
        limits: VelocityRange,
        seed: int,
    ) -> None:
        self._posterior, self._ensemble, self._strategy = posterior, ensemble, strategy
        self._limits = limits
        self._generator = torch.Generator().manual_seed(seed)

    def decide(self, frame: Frame) -> Decision:
        """See, predict, decide; the command stays inside the limits."""
        z = self._posterior.sample(fit_image(frame.rgb), self._generator)
        samples = self._ensemble.predict(z)
        decision = self._strategy.decide(samples)
        return replace(decision, command=self._limits.clip(decision.command))


def load_pipeline(
    model: str, strategy: str | None = None, seed: int = 0, *, direction: str = "cw"
) -> Pipeline:
    """Load a model by name, with its own strategy or another, ready for its first frame.

    `direction` is the course's, "cw" or "ccw", seen from above. Raises ModelError for the model,
    UsageError for the strategy. Sets torch to one thread, for the whole process.
    """
    torch.set_num_threads(THREADS)
    loaded = models.load(model)
    config = loaded.config
    posterior = make_posterior(config.perception, loaded.encoder)
    ensemble = PolicyEnsemble(loaded.policies, config.policy.velocity_range)
    ensemble.predict(posterior.sample(BLANK, torch.Generator()))  # torch's first pass is slow
    return Pipeline(
        posterior,
        ensemble,
        make_strategy(strategy or config.strategy, direction=direction),
        limits=config.policy.velocity_range,
        seed=seed,
    )
