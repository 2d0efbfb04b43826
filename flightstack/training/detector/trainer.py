"""Train the gate detector on scenes; half of the images of each batch are mirrored."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from jaxtyping import Float32
from numpy.typing import NDArray
from torch import Tensor

from flightstack.arrays import RgbStack
from flightstack.networks.gate_network import GateNetwork
from flightstack.networks.images import network_input
from flightstack.training.detector.losses import SCORE_WEIGHT, loss_of, targets_of
from flightstack.training.detector.scenes import IMAGE_PX
from flightstack.training.detector.store import Scenes

Labels = Float32[NDArray[np.float32], "K G 4"]
MIRRORED_SHARE = 0.5
EDGE_PX = 1e-3  # a mirrored 0 must stay inside the image
VALIDATION_BATCH = 200


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorSettings:
    """How it is trained."""

    seed: int = 0
    epochs: int = 5
    batch: int = 64
    learning_rate: float = 2e-3
    weight_decay: float = 1e-4
    warm_up_steps: int = 200
    last_rate_share: float = 0.02  # of the learning rate, at the end of the cosine
    max_gradient: float = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Epoch:
    """How far it is."""

    number: int
    score_loss: float  # on the validation scenes
    value_loss: float


def train_detector(
    scenes: Scenes,
    validation: Scenes,
    settings: DetectorSettings,
    say: Callable[[Epoch], None],
) -> GateNetwork:
    """Train on all scenes, so many times; tells of every epoch."""
    torch.manual_seed(settings.seed)
    rng = np.random.default_rng(settings.seed)
    network = GateNetwork()
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimiser = torch.optim.AdamW(
        network.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    steps = settings.epochs * (len(scenes) // settings.batch)
    step = 0
    for number in range(1, settings.epochs + 1):
        order = rng.permutation(len(scenes))
        for start in range(0, len(scenes) - settings.batch + 1, settings.batch):
            rows = np.sort(order[start : start + settings.batch])
            for group in optimiser.param_groups:
                group["lr"] = _rate(step, steps, settings)
            _step(network, optimiser, *_mirrored(rng, scenes.images[rows], scenes.labels[rows]),
                  settings.max_gradient)  # fmt: skip
            step += 1
        score, value = validate(network, validation)
        say(Epoch(number=number, score_loss=score, value_loss=value))
    network.eval()
    return network


def validate(network: GateNetwork, scenes: Scenes) -> tuple[float, float]:
    """Return the two losses on scenes that it was not trained on."""
    network.eval()
    sums = np.zeros(2)
    count = 0
    with torch.inference_mode():
        for start in range(0, len(scenes), VALIDATION_BATCH):
            rows = slice(start, start + VALIDATION_BATCH)
            targets = targets_of(torch.from_numpy(scenes.labels[rows]))
            losses = loss_of(network(network_input(scenes.images[rows])), targets)
            sums += [float(loss) for loss in losses]
            count += 1
    network.train()
    return float(sums[0] / count), float(sums[1] / count)


def _step(
    network: GateNetwork,
    optimiser: torch.optim.Optimizer,
    images: RgbStack,
    labels: Labels,
    max_gradient: float,
) -> Tensor:
    score, value = loss_of(network(network_input(images)), targets_of(torch.from_numpy(labels)))
    loss = SCORE_WEIGHT * score + value
    optimiser.zero_grad()
    loss.backward()  # type: ignore[no-untyped-call]
    torch.nn.utils.clip_grad_norm_(network.parameters(), max_gradient)
    optimiser.step()
    return loss


def _mirrored(
    rng: np.random.Generator, images: RgbStack, labels: Labels
) -> tuple[RgbStack, Labels]:
    chosen = rng.random(len(images)) < MIRRORED_SHARE
    images, labels = images.copy(), labels.copy()
    images[chosen] = images[chosen][:, :, ::-1]
    labels[chosen, :, 0] = IMAGE_PX - EDGE_PX - labels[chosen, :, 0]
    labels[chosen, :, 3] *= -1.0
    return images, labels


def _rate(step: int, steps: int, settings: DetectorSettings) -> float:
    share = settings.last_rate_share
    cosine = 0.5 * (1.0 + math.cos(math.pi * step / steps))
    warm = min(1.0, (step + 1) / settings.warm_up_steps)
    return settings.learning_rate * warm * (share + (1.0 - share) * cosine)
