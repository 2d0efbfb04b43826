"""Train a stack of policies by imitation, on samples of a frozen encoder's latents."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from jaxtyping import Float32, Int64
from numpy.typing import NDArray
from torch import Tensor

from flightstack.errors import UsageError
from flightstack.networks.dronet import Dronet
from flightstack.networks.policy_stack import PolicyStack, gaussian_nll, mixture_nll
from flightstack.policy.config import PolicyConfig
from flightstack.records import VELOCITIES
from flightstack.training.checkpoint import Checkpoint, identity_of
from flightstack.training.data.dataset import Dataset
from flightstack.training.perception.latents import LatentSource
from flightstack.training.policy.metrics import PolicyMetrics, measure_policy
from flightstack.training.policy.predictions import predict
from flightstack.training.presets import PolicySettings
from flightstack.training.progress import Curves
from flightstack.training.runs import Report, write_run

REPORT_EVERY = 10  # epochs
VALIDATION_SEED = 1 << 40  # far from any epoch's


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyRun:
    """What a finished training left behind."""

    folder: Path
    stack: PolicyStack
    config: PolicyConfig
    metrics: PolicyMetrics


class PolicyTrainer:
    """The stack, the optimiser, the latents and the labels of one run."""

    def __init__(
        self,
        dataset: Dataset,
        latents: LatentSource,
        settings: PolicySettings,
    ) -> None:
        if tuple(dataset.label_names) != VELOCITIES:
            raise UsageError(f"control data needs {VELOCITIES}, got {dataset.label_names}")
        self.settings, self.latents = settings, latents
        self.labels = dataset.labels
        self.train, self.validation = dataset.splits["train"], dataset.splits["validation"]
        self.device = latents.features.device
        self.config = PolicyConfig(
            members=settings.members,
            probabilistic=settings.probabilistic,
            hidden=settings.hidden,
            mixture=settings.mixture,
            velocity_range=settings.velocity_range,
        )
        z = latents.draw(self._generator(-1))[torch.from_numpy(self.train).to(self.device)]
        generator = torch.Generator().manual_seed(settings.seed)
        stack = PolicyStack(self.config, latent_dims=z.shape[1], generator=generator)
        stack.latent_mean.copy_(z.mean(dim=0))
        stack.latent_std.copy_(z.std(dim=0).clamp(min=1e-6))
        self.stack = stack.to(self.device)
        scaled = settings.velocity_range.encode(dataset.labels)
        self.targets = torch.from_numpy(scaled).to(self.device)
        self.optimizer = torch.optim.AdamW(
            self.stack.parameters(),
            lr=settings.learning_rate,
            weight_decay=settings.weight_decay,
            fused=True,
        )

    def epoch(self, number: int) -> float:
        """Let every member pass over its data once, with fresh latents; returns the mean loss."""
        settings = self.settings
        generator = self._generator(number)
        z = torch.stack([self.latents.draw(generator) for _ in range(settings.members)])
        z = z.clone()  # out of inference mode, so that gradients may pass by
        order = torch.from_numpy(self._order(number)).to(self.device)  # (N, K)
        steps = order.shape[1] // settings.batch
        rows = torch.arange(settings.members, device=self.device)[:, None]
        loss_sum = 0.0
        for step in range(steps):
            share = (number * steps + step) / (steps * settings.epochs)
            for group in self.optimizer.param_groups:
                group["lr"] = settings.learning_rate * 0.5 * (1.0 + math.cos(math.pi * share))
            at = order[:, step * settings.batch : (step + 1) * settings.batch]
            loss = self._loss(z[rows, at], self.targets[at])
            self.optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self.optimizer.step()
            loss_sum += float(loss.detach())
        return loss_sum / (steps * settings.members)

    def measure(self) -> PolicyMetrics:
        """Measure the pool of all members and 32 latents on the validation images, recalibrated."""
        mean, var = predict(
            self.stack,
            self.latents,
            self.config.velocity_range,
            self.validation,
            generator=self._generator(VALIDATION_SEED),
        )
        return measure_policy(
            mean,
            var,
            self.labels[self.validation].astype(np.float64),
            members=self.settings.members,
            constant=self.labels[self.train].mean(axis=0, dtype=np.float64),
        )

    def _loss(
        self, z: Float32[Tensor, "N B Z"], targets: Float32[Tensor, "N B 4"]
    ) -> Float32[Tensor, ""]:
        """Sum over members and velocities, mean over the batch."""
        if self.settings.mixture > 1:
            joint: Tensor = mixture_nll(self.stack.heads(z), targets).mean(dim=1).sum()
            return joint
        mean, logvar = self.stack(z)
        if self.settings.probabilistic:
            errors = gaussian_nll(mean, logvar, targets)
        else:
            errors = (mean - targets).square()
        total: Tensor = errors.mean(dim=1).sum()
        return total

    def _order(self, number: int) -> Int64[NDArray[np.int64], "N K"]:
        """Every member's own order of its own data."""
        seed, members = self.settings.seed, range(self.settings.members)
        own = [self.train] * len(members)
        if self.settings.bootstrap:
            draws = (np.random.default_rng([seed, 1, member]) for member in members)
            own = [rng.choice(self.train, len(self.train)) for rng in draws]
        return np.stack(
            [np.random.default_rng([seed, 2, n, number + 1]).permutation(own[n]) for n in members]
        )

    def _generator(self, number: int) -> torch.Generator:
        return torch.Generator(self.device).manual_seed(self.settings.seed * 100_003 + number + 1)


def train_policy(
    dataset: Dataset,
    encoder: Dronet,
    settings: PolicySettings,
    folder: Path,
    *,
    perception: str,
    device: torch.device,
    report: Report = print,
) -> PolicyRun:
    """Train, or go on with, the run in `folder`; `perception` names the encoder's training.

    Raises TrainingError when the loss is not finite or, if it must learn, a velocity is no better
    predicted than by a constant; UsageError when the data or the folder do not fit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    trainer = PolicyTrainer(dataset, LatentSource(encoder, dataset.images, device), settings)
    identity = {**identity_of(settings, data_sha256=dataset.sha256), "perception": perception}
    checkpoint = Checkpoint(
        folder, identity=identity, model=trainer.stack, optimizer=trainer.optimizer
    )
    begin = checkpoint.restore()
    curves = Curves(folder, done=begin, epochs=settings.epochs, report=report)
    for done, loss in checkpoint.train(trainer.epoch, range(begin, settings.epochs)):
        measured = done % REPORT_EVERY == 0 or done == settings.epochs
        values = trainer.measure().curves() if measured else {}
        left = curves.add(done, loss=loss, **values)
        if measured and done < settings.epochs:
            head = f"{folder.name} epoch {done}/{settings.epochs}, {left} left"
            report(f"{head}: loss {loss:.3f}, NLL {values['nll']:.2f} nats")
    metrics = trainer.measure()
    report(f"{folder.name}: {metrics.line()}")
    stack = trainer.stack.cpu().eval()
    write_run(folder, "policy", stack, {**identity, "metrics": metrics.as_dict()})
    if settings.must_learn:
        metrics.require_healthy()
    return PolicyRun(folder=folder, stack=stack, config=trainer.config, metrics=metrics)
