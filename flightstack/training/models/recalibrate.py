"""Measure a model on validation flights, as it flies: best member, variance factors, card, metrics.

A stack of policies is calibrated at the end of its training over 32 latent samples an image. The
models that share it differ in how many they draw, or draw none: so each has factors of its own.
"""

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from flightstack import models
from flightstack.arrays import PerImage, RgbStack
from flightstack.models import Model
from flightstack.perception.posterior import make_posterior
from flightstack.policy.ensemble import PolicyEnsemble
from flightstack.training.data.dataset import Dataset
from flightstack.training.data.flights import fly_until
from flightstack.training.models.assemble import METRICS_FILE, describe_model
from flightstack.training.models.catalogue import read_catalogue
from flightstack.training.policy.metrics import PolicyMetrics, measure_policy
from flightstack.training.policy.predictions import components
from flightstack.training.recipe import Recipe
from flightstack.training.runs import Report
from flightstack.training.seeds import VALIDATION_TRACKS

VALIDATION_FLIGHTS = 5  # enters the seed, where data and evaluation have 1 to 4


@dataclass(frozen=True, slots=True, kw_only=True)
class Labelled:
    """Images of flights and what the expert commanded."""

    images: RgbStack
    commands: PerImage  # m/s, rad/s

    @classmethod
    def flown(cls, recipe: Recipe, *, images: int, seed: int) -> Self:
        """Fly a recipe's expert over validation tracks; raises UsageError for no images."""
        rng = np.random.default_rng([seed, VALIDATION_FLIGHTS])
        seen, labels = fly_until(rng, recipe.flights, tracks=VALIDATION_TRACKS, images=images)
        return cls(images=seen, commands=labels.astype(np.float64))

    @classmethod
    def held_out(cls, dataset: Dataset) -> Self:
        """Take a dataset's validation split."""
        at = dataset.splits["validation"]
        return cls(images=dataset.images[at], commands=dataset.labels[at].astype(np.float64))


def recalibrate(
    name: str, validation: Labelled, *, seed: int, out: Path | None = None, report: Report = print
) -> Path:
    """Write what the validation images say into the model's folder, or a copy; its weights stay.

    Returns the folder. Raises ModelError when there is no such model.
    """
    model, found = models.load(name), models.find(name)
    folder, config = out or found, model.config
    if folder.resolve() != found.resolve():
        shutil.copytree(found, folder, dirs_exist_ok=True)
    measured = measure(model, validation, seed=seed)
    policy = replace(
        config.policy, variance_factor=measured.variance_factor, best_member=measured.best_member
    )
    config = replace(config, policy=policy)
    metrics: dict[str, Any] = json.loads((folder / METRICS_FILE).read_text())
    metrics["policy"] = measured.as_dict()
    describe_model(folder, config, read_catalogue()[config.name], metrics)
    report(f"{folder.name}: {measured.line()}")
    return folder


def measure(model: Model, validation: Labelled, *, seed: int) -> PolicyMetrics:
    """Let a model look at images one by one, its variances as they were learned."""
    config = model.config
    posterior = make_posterior(config.perception, model.encoder, seed=seed)
    ensemble = PolicyEnsemble(model.policies, config.policy.velocity_range)
    said = [ensemble.predict(posterior.sample(rgb)) for rgb in validation.images]
    return measure_policy(
        components([one.mean for one in said], axis=2),
        components([one.var for one in said], axis=2),
        validation.commands,
        members=config.policy.members,
        constant=validation.commands.mean(axis=0),
    )
