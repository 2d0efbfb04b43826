"""Judge one model on images alone: accuracy, calibration, and what its uncertainty detects."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from flightstack import models
from flightstack.evaluation.offline.material import Material
from flightstack.evaluation.offline.predicting import PARTS, Predictions
from flightstack.evaluation.offline.scenes import DOUBLE_GATE, PLAIN
from flightstack.evaluation.offline.scores import LEVELS, coverage_curve, detection, mixture_scores
from flightstack.libraries import load_library
from flightstack.models import Model
from flightstack.perception.labels import LABELS, RANGE
from flightstack.records import VELOCITIES
from flightstack.training.recipe import Recipe

BAND_M = (1.5, 8.0)  # where a passage is decided


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """All figures of one model, as they go into JSON."""

    model: str
    images: int
    scene_images: int
    velocities: dict[str, dict[str, Any]]  # scores, coverage90 and the curve, by velocity
    poses: dict[str, dict[str, float]]  # mean absolute errors: all, in BAND_M, of a constant
    auroc: dict[str, dict[str, float]]  # by kind of scene, then by part of the uncertainty
    multimodal: dict[str, list[float]]  # share of images, by velocity: in flight, double gates
    strategies_differ: dict[str, dict[str, float]]  # |mi-mode - de-mean|, by velocity


def recipe_of(name: str) -> Recipe:
    """Which recipe a model was trained by; raises ModelError when there is no such model."""
    folder = models.find(name)
    return Recipe.beside(folder, models.read_config(folder / models.CONFIG_FILE).recipe)


def judge(name: str, material: Material, *, seed: int) -> Judgement:
    """Judge a model by name."""
    load_library("torch", "training")
    model = models.load(name)
    flown = Predictions.of(model, material.flights, seed=seed)
    scenes = {
        kind: Predictions.of(model, images, seed=seed) for kind, images in material.scenes.items()
    }
    return Judgement(
        model=name,
        images=len(material.flights),
        scene_images=len(material.scenes[PLAIN]),
        velocities=_velocities(flown, material),
        poses=_poses(name, material),
        auroc=_auroc(model, scenes),
        multimodal={
            "in flight": _multimodal(flown),
            DOUBLE_GATE: _multimodal(scenes[DOUBLE_GATE]),
        },
        strategies_differ=_differences(flown),
    )


def _velocities(flown: Predictions, material: Material) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for k, name in enumerate(VELOCITIES):
        mixture = flown.mean[..., k], flown.var[..., k], material.commands[:, k]
        curve = coverage_curve(*mixture)
        found[name] = {
            **mixture_scores(*mixture),
            "coverage90": curve[LEVELS.index(0.9)],
            "calibration": {"levels": list(LEVELS), "covered": curve},
        }
    return found


def _poses(name: str, material: Material) -> dict[str, dict[str, float]]:
    # Here, not above: what else is judged needs no torch.
    from flightstack.networks.gate_pose import read_poses  # noqa: PLC0415
    from flightstack.networks.trained import load_trained  # noqa: PLC0415

    read = read_poses(load_trained(name), material.views)
    errors = np.abs(read - material.poses)
    ranges = material.poses[:, RANGE]
    in_band = (ranges > BAND_M[0]) & (ranges < BAND_M[1])
    constant = np.abs(material.poses - np.median(material.poses, axis=0))
    return {
        name: {
            "mae": float(errors[:, k].mean()),
            "mae_in_band": float(errors[in_band, k].mean()),
            "mae_of_constant": float(constant[:, k].mean()),
        }
        for k, name in enumerate(LABELS)
    }


def _auroc(model: Model, scenes: dict[str, Predictions]) -> dict[str, dict[str, float]]:
    """One score per image and part: the deviations in shares of each velocity's range, averaged."""
    scale = model.config.policy.velocity_range.scale
    scores = {
        kind: (made.uncertainty / scale).mean(axis=2) for kind, made in scenes.items()
    }  # (K, P)
    return {
        kind: {part: detection(scores[PLAIN][:, p], score[:, p]) for p, part in enumerate(PARTS)}
        for kind, score in scores.items()
        if kind != PLAIN
    }


def _multimodal(made: Predictions) -> list[float]:
    return [float(share) for share in (made.modes > 1).mean(axis=0)]


def _differences(made: Predictions) -> dict[str, dict[str, float]]:
    apart = np.abs(made.mi_mode - made.de_mean)
    return {
        name: {
            "mean": float(apart[:, k].mean()),
            "median": float(np.median(apart[:, k])),
            "p90": float(np.quantile(apart[:, k], 0.9)),
        }
        for k, name in enumerate(VELOCITIES)
    }
