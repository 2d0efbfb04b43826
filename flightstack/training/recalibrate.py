"""Measure a finished model on control data anew: best member, variance factors, card, metrics."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from flightstack import models
from flightstack.tables import table_text
from flightstack.training.assemble import CARD_FILE, METRICS_FILE
from flightstack.training.card import model_card
from flightstack.training.catalogue import read_catalogue
from flightstack.training.dataset import Dataset
from flightstack.training.latents import LatentSource
from flightstack.training.perception import Report
from flightstack.training.policy import VALIDATION_SEED
from flightstack.training.policy_metrics import measure_policy
from flightstack.training.predictions import predict


def recalibrate(name: str, dataset: Dataset, *, seed: int, report: Report = print) -> Path:
    """Write what the validation images say into the model's folder; its weights stay.

    Raises ModelError when there is no such model.
    """
    model = models.load(name)
    folder, config = models.find(name), model.config
    at = dataset.splits["validation"]
    mean, var = predict(
        model.policies,
        LatentSource(model.encoder, dataset.images, torch.device("cpu")),
        config.policy.velocity_range,
        at,
        generator=torch.Generator().manual_seed(VALIDATION_SEED + seed),
    )
    measured = measure_policy(
        mean,
        var,
        dataset.labels[at].astype(float),
        members=config.policy.members,
        constant=dataset.labels[dataset.splits["train"]].mean(axis=0, dtype=float),
        recalibrate=config.policy.probabilistic,
    )
    policy = replace(
        config.policy, variance_factor=measured.variance_factor, best_member=measured.best_member
    )
    config = replace(config, policy=policy)
    metrics: dict[str, Any] = json.loads((folder / METRICS_FILE).read_text())
    metrics["policy"] = measured.as_dict()
    (folder / models.CONFIG_FILE).write_text(table_text(config))
    (folder / METRICS_FILE).write_text(json.dumps(metrics, indent=2) + "\n")
    (folder / CARD_FILE).write_text(model_card(config, read_catalogue()[config.name], metrics))
    report(f"{folder.name}: {measured.line()}")
    return folder
