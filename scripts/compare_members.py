"""Compare ways to make the members of an ensemble differ: bootstrapped data, mixture heads, both.

Trains each kind of ensemble on the latents of a model's own encoder, and prints how good it is and
how far its members disagree: on validation images, and where two gates are equally near.
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from rich.console import Console
from rich.table import Table

from flightstack.evaluation.offline.scenes import render_scene
from flightstack.networks.policy_stack import PolicyStack
from flightstack.networks.trained import TrainedModel, load_trained
from flightstack.records import VELOCITIES
from flightstack.training.batches import Images
from flightstack.training.data.dataset import Dataset, read_dataset
from flightstack.training.perception.latents import LatentSource
from flightstack.training.policy.predictions import predict
from flightstack.training.policy.trainer import train_policy
from flightstack.training.presets import PolicySettings, policy_settings

KINDS = {  # bootstrapped data, Gaussians a member
    "as trained": (False, 1),
    "bootstrap": (True, 1),
    "mixture of 3": (False, 3),
    "both": (True, 3),
}
CPU = torch.device("cpu")


def main() -> None:
    """Train, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", default="strong/m0", help="whose encoder (default: strong/m0)")
    parser.add_argument("--data", type=Path, required=True, help="folder of control data")
    parser.add_argument("--epochs", type=int, default=15)
    parser.add_argument("--images", type=int, default=400, help="of double gates (default: 400)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    model, data = load_trained(options.model), read_dataset(options.data)
    gates = render_scene("double gate", options.images, seed=options.seed)
    table = Table(title=f"Members on the encoder of {options.model}, {options.epochs} epochs")
    for column in ("members", "NLL, sum", "90 % covers", "disagree: validation", "double gates"):
        table.add_column(column)
    for kind, (bootstrap, mixture) in KINDS.items():
        settings = policy_settings(
            "quick", kind="ensemble", seed=options.seed, epochs=options.epochs
        )
        changed = replace(settings, bootstrap=bootstrap, mixture=mixture)
        table.add_row(kind, *_measure(changed, model, data, gates))
    Console().print(table)
    print(f"Disagreement: deviation between the members' means of {', '.join(VELOCITIES)}.")


def _measure(
    settings: PolicySettings, model: TrainedModel, data: Dataset, gates: Images
) -> tuple[str, ...]:
    with tempfile.TemporaryDirectory() as folder:
        run = train_policy(
            data, model.encoder, settings, Path(folder), perception="this", device=CPU
        )
    metrics = run.metrics
    covered = " ".join(f"{value:.0%}" for value in metrics.coverage)
    on_gates = disagreement(run.stack, model, gates, settings)
    return (
        f"{sum(metrics.nll):.2f}",
        covered,
        " ".join(f"{value:.3f}" for value in metrics.policy_std),
        " ".join(f"{value:.3f}" for value in on_gates),
    )


def disagreement(
    stack: PolicyStack, model: TrainedModel, images: Images, settings: PolicySettings
) -> tuple[float, ...]:
    """Root mean square deviation between the members' mean predictions, (4,)."""
    mean, _ = predict(
        stack,
        LatentSource(model.encoder, images, CPU),
        settings.velocity_range,
        np.arange(len(images)),
        generator=torch.Generator().manual_seed(settings.seed),
    )
    member_mean = mean.reshape(settings.members, -1, *mean.shape[1:]).mean(axis=1)
    deviation = member_mean - member_mean.mean(axis=0)
    return tuple(np.sqrt(np.square(deviation).mean(axis=(0, 1))).tolist())


if __name__ == "__main__":
    main()
