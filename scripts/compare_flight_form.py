"""Hold a model's flight form against its networks in torch, on images of flights.

Both get the same masks and the same noise. Prints the largest difference of a latent sample, of a
mean and a variance, and of the command that comes of them; 1 where a command differs by 1e-4.
"""

import argparse

import numpy as np
import torch

from flightstack import models
from flightstack.arrays import Latents, RgbStack
from flightstack.decision.strategies import make_strategy
from flightstack.networks.images import network_input
from flightstack.networks.trained import TrainedModel, load_trained
from flightstack.perception.config import FEATURES
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.records import ActionSamples
from flightstack.training.models.recalibrate import Labelled
from flightstack.training.recipe import Recipe

MAX_DIFFERENCE = 1e-4  # m/s, rad/s


def main() -> int:
    """Compare, print, and return 1 where the two are not the same."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", default="strong/m0", help="(default: strong/m0)")
    parser.add_argument("--images", type=int, default=10_000, help="(default: 10,000)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    torch.set_num_threads(1)
    flown = Labelled.flown(Recipe.load("strong"), images=options.images, seed=options.seed)
    largest = compare(options.model, flown.images, seed=options.seed)
    for what, difference in largest.items():
        print(f"{options.model}, {len(flown.images)} images, {what}: {difference:.1e}")
    return 0 if largest["command, m/s or rad/s"] < MAX_DIFFERENCE else 1


def compare(name: str, images: RgbStack, *, seed: int) -> dict[str, float]:
    """Return the largest differences over all images."""
    model, trained = models.load(name), load_trained(name)
    perception, policy = model.config.perception, model.config.policy
    strategy = make_strategy("de-mean")
    ensemble = PolicyEnsemble(model.policies, policy.velocity_range, policy.variance_factor)
    rng = np.random.default_rng(seed)
    found = []
    for rgb in images:
        kept = rng.random((perception.samples, FEATURES), dtype=np.float32) >= perception.dropout
        masks = kept * np.float32(1.0 / (1.0 - perception.dropout))
        shape = (perception.samples, perception.latent_dims)
        noise = rng.standard_normal(shape, dtype=np.float32)
        z = model.encoder.sample(rgb, masks, noise)
        other_z, other = _in_torch(trained, rgb[None], torch.from_numpy(masks), noise)
        said = ensemble.predict(z)
        commands = [strategy.decide(samples).command for samples in (said, other)]
        pairs = ((z, other_z), (said.mean, other.mean), (said.var, other.var), commands)
        found.append([float(np.abs(one - another).max()) for one, another in pairs])
    names = ("latent sample", "mean, m/s or rad/s", "variance", "command, m/s or rad/s")
    return dict(zip(names, np.max(found, axis=0).tolist(), strict=True))


def _in_torch(
    trained: TrainedModel, rgb: RgbStack, masks: torch.Tensor, noise: Latents
) -> tuple[Latents, ActionSamples]:
    policy = trained.config.policy
    scale = policy.velocity_range.scale
    with torch.inference_mode():
        features = trained.encoder.trunk(network_input(rgb))
        latent_mean, latent_logvar = trained.encoder.head(features * masks)
        z = latent_mean + torch.from_numpy(noise) * torch.exp(0.5 * latent_logvar)
        mean, logvar = trained.policies(z)
    return z.numpy(), ActionSamples(
        mean=mean.numpy() * scale + policy.velocity_range.offset,
        var=np.exp(logvar.numpy()) * scale**2 * policy.variance_factor,
    )


if __name__ == "__main__":
    raise SystemExit(main())
