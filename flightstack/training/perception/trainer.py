"""Train a CM-VAE, watch that nothing collapses, and write what came out."""

import math
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch

from flightstack.errors import UsageError
from flightstack.networks.cmvae import CmVae, LossTerms
from flightstack.perception.labels import LABELS, MIRRORED, LabelScale
from flightstack.training.batches import ImageSource, mirror, shuffled
from flightstack.training.checkpoint import Checkpoint, identity_of
from flightstack.training.data.dataset import Dataset
from flightstack.training.perception.metrics import PerceptionMetrics, measure_perception
from flightstack.training.perception.pictures import write_reconstructions, write_traversals
from flightstack.training.perception.start import Start
from flightstack.training.presets import PerceptionSettings
from flightstack.training.progress import Curves
from flightstack.training.runs import Report, write_run

EPOCH_VALIDATION_IMAGES = 4096  # enough for a progress line; the last epoch measures all
PICTURE_IMAGES = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptionRun:
    """What a finished training left behind."""

    folder: Path
    model: CmVae
    scale: LabelScale
    metrics: PerceptionMetrics


class PerceptionTrainer:
    """The networks, the optimiser and the data of one run."""

    def __init__(
        self,
        dataset: Dataset,
        settings: PerceptionSettings,
        device: torch.device,
        start: Start | None = None,
    ) -> None:
        if tuple(dataset.label_names) != LABELS:
            raise UsageError(
                f"perception data needs the labels {LABELS}, got {dataset.label_names}"
            )
        self.settings, self.device = settings, device
        self.train, self.validation = dataset.splits["train"], dataset.splits["validation"]
        self.labels = dataset.labels
        labels = dataset.labels[self.train]
        self.scale = start.label_scale if start else LabelScale.of(labels)
        self.source = ImageSource(dataset.images, self.scale.encode(dataset.labels), device)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(settings.seed)  # torch initialises layers from the global generator
            model = CmVae(latent_dims=settings.latent_dims, dropout=settings.dropout)
        self.weights = settings.weights
        if start is not None and not start.put_into(model):
            self.weights = replace(self.weights, image=0.0)  # a decoder at random teaches nothing
        self.model = model.to(device=device, memory_format=torch.channels_last)  # type: ignore[call-overload]
        self.optimizer = torch.optim.AdamW(
            self.model.parameters(),
            lr=settings.learning_rate,
            weight_decay=settings.weight_decay,
            fused=True,
        )
        self.signs = torch.tensor(MIRRORED, dtype=torch.float32, device=device)
        self.bfloat16 = device.type != "cpu" or cpu_has_bfloat16()

    def epoch(self, number: int) -> float:
        """Pass over the training images once; returns the mean loss."""
        settings = self.settings
        generator = torch.Generator(self.device).manual_seed(settings.seed * 100_003 + number)
        steps = len(self.train) // settings.batch
        reconstructed = max(1, round(settings.batch * settings.image_fraction))
        loss_sum = torch.zeros((), device=self.device)
        self.model.train()
        batches = shuffled(self.train, settings.batch, [settings.seed, number])
        for step, indices in enumerate(batches, start=number * steps):
            self._set_learning_rate(step, steps * settings.epochs)
            images, labels = mirror(*self.source.fetch(indices), self.signs, generator)
            with torch.autocast(self.device.type, torch.bfloat16, enabled=self.bfloat16):
                terms: LossTerms = self.model.loss_terms(
                    images, labels, generator=generator, reconstructed=reconstructed
                )
            loss = terms.total(self.weights)
            self.optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            self.optimizer.step()
            loss_sum += loss.detach()
        return float(loss_sum) / steps

    def measure(self, limit: int | None = None) -> PerceptionMetrics:
        """Measure on the validation images, or on the first `limit` of them."""
        indices = self.validation[:limit]
        constant = np.median(self.labels[self.train], axis=0)
        return measure_perception(
            self.model, self.source, indices, self.labels[indices], self.scale, constant
        )

    def _set_learning_rate(self, step: int, steps: int) -> None:
        warmup = min(1.0, (step + 1) / self.settings.warmup_steps)
        cosine = 0.5 * (1.0 + math.cos(math.pi * step / steps))
        for group in self.optimizer.param_groups:
            group["lr"] = self.settings.learning_rate * warmup * cosine


def train_perception(
    dataset: Dataset,
    settings: PerceptionSettings,
    folder: Path,
    *,
    device: torch.device,
    start: Start | None = None,
    report: Report = print,
) -> PerceptionRun:
    """Train, or go on with, the run in `folder`; from a `start`, or from nothing.

    Raises TrainingError when the loss is not finite and, if it must learn, when a label is no
    better predicted than by a constant, or when the posterior collapsed; UsageError when the data
    or the folder do not fit.
    """
    folder.mkdir(parents=True, exist_ok=True)
    trainer = PerceptionTrainer(dataset, settings, device, start)
    if len(trainer.train) < settings.batch:
        raise UsageError(f"{len(trainer.train)} training images are fewer than one batch")
    identity = identity_of(settings, data_sha256=dataset.sha256)
    identity |= {"start": start.sha256} if start else {}
    checkpoint = Checkpoint(
        folder, identity=identity, model=trainer.model, optimizer=trainer.optimizer
    )
    if begin := checkpoint.restore():
        report(f"{folder.name}: going on after epoch {begin} of {settings.epochs}")
    curves = Curves(folder, done=begin, epochs=settings.epochs, report=report)
    started = time.perf_counter()
    for done, loss in checkpoint.train(trainer.epoch, range(begin, settings.epochs)):
        rate = len(trainer.train) / (time.perf_counter() - started)
        metrics = trainer.measure(EPOCH_VALIDATION_IMAGES)
        left = curves.add(done, loss=loss, **metrics.curves(), images_per_s=rate)
        head = f"{folder.name} epoch {done}/{settings.epochs}, {left} left"
        report(f"{head}: loss {loss:.4f}, {rate:.0f} images/s, {metrics.line()}")
        started = time.perf_counter()
    return _finish(trainer, identity, folder, report)


def cpu_has_bfloat16() -> bool:
    """Whether the processor multiplies bfloat16 natively; in software it would only be slower."""
    return bool(torch.cpu._is_avx512_bf16_supported())  # noqa: SLF001  torch has no public name


def _finish(
    trainer: PerceptionTrainer,
    identity: dict[str, Any],
    folder: Path,
    report: Report,
) -> PerceptionRun:
    metrics = trainer.measure()
    model = trainer.model.eval()
    summary = {**identity, "label_scale": asdict(trainer.scale), "metrics": metrics.as_dict()}
    write_run(folder, "perception", model, summary)
    images, _ = trainer.source.fetch(trainer.validation[:PICTURE_IMAGES])
    write_reconstructions(model, images, folder / "reconstructions.png")
    write_traversals(model, images, folder / "traversals.png")
    report(f"{folder.name}:\n{metrics.table()}")
    if trainer.settings.must_learn:
        metrics.require_healthy()
    return PerceptionRun(folder=folder, model=model, scale=trainer.scale, metrics=metrics)
