"""Write a model's card: what it is, how it was trained, how good it is, what it is not for."""

from typing import Any

import numpy as np

from flightstack.models import ModelConfig
from flightstack.perception.labels import LABELS
from flightstack.records import VELOCITIES
from flightstack.training.models.catalogue import ModelPlan
from flightstack.training.perception.metrics import BAND_M
from flightstack.training.policy.calibration import GOOD_COVERAGE

ENCODERS = {
    "mcd": "CM-VAE whose encoder has a dropout layer, sampled by Monte-Carlo dropout",
    "plain": "CM-VAE with a deterministic encoder",
}
POLICIES = {
    "ensemble": "an ensemble of probabilistic policies",
    "single": "one probabilistic policy",
    "deterministic": "one deterministic policy",
}

FRONT_MATTER = """---
license: bsd-3-clause
library_name: flightstack
pipeline_tag: robotics
tags: [uav, navigation, uncertainty, imitation-learning, cm-vae]
---"""


def model_card(config: ModelConfig, plan: ModelPlan, metrics: dict[str, Any]) -> str:
    """Write the card by the Hugging Face convention: YAML front matter, then Markdown."""
    samples = config.policy.members * config.perception.samples
    return f"""{FRONT_MATTER}
# {config.recipe}/{config.name}

{ENCODERS[plan.encoder]}, and {POLICIES[plan.policy]}.
From one 64 x 64 image to {samples} Gaussian prediction{"s" if samples > 1 else ""} of each velocity
command. One of the models of Arnez et al. 2022, *Quantifying and Using System Uncertainty in UAV
Navigation*.

{_facts_table(config)}

## Use

    python -m flightstack.companion --model {config.recipe}/{config.name}

Made for passing gates in the simulator that comes with it. It has never flown a real vehicle, sees
gates of one shape and size only, and its predicted uncertainty is calibrated on its own recipe's
validation data, not on other scenes.

## Training

{_training_table(metrics["trained"])}

## Perception, validation images

{_perception_table(metrics["perception"])}

{metrics["perception"]["active_units"]} of {config.perception.latent_dims} latent units are active.

## Policy, validation flights

{_policy_table(metrics["policy"])}

Over {metrics["policy"]["images"]} images, as the model flies. RMSE is of the mean of all
predictions; NLL and coverage are of their mixture.

{_recalibration(config)}
"""


def _recalibration(config: ModelConfig) -> str:
    pairs = zip(VELOCITIES, config.policy.variance_factor, strict=True)
    scaled = [f"{name} x {factor:.2f}" for name, factor in pairs if factor != 1.0]
    if not scaled:
        return "Predicted variances are as they were learned: none needed recalibration."
    low, high = map(_percent, GOOD_COVERAGE)
    return (
        f"Predicted variances are recalibrated on the same images: {', '.join(scaled)}.\n"
        f"As learned, their 90 % intervals covered less than {low} or more than {high}."
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _facts_table(config: ModelConfig) -> str:
    perception = config.perception
    return f"""| | |
|---|---|
| latent samples | {perception.samples} ({perception.sampling}) |
| policies | {config.policy.members} |
| default strategy | {config.strategy} |
| data recipe | {config.recipe} |"""


def _training_table(trained: dict[str, Any]) -> str:
    return f"""| | |
|---|---|
| preset | {trained["preset"]} |
| encoder seed | {trained["perception_seed"]} |
| policy seed | {trained["policy_seed"]} |
| commit | `{trained["commit"]}` |
| perception data, sha256 | `{trained["perception_data_sha256"]}` |
| control data, sha256 | `{trained["policy_data_sha256"]}` |"""


def _perception_table(metrics: dict[str, Any]) -> str:
    lines = [
        "| label | mean absolute error | from {} to {} m | of a constant |".format(*BAND_M),
        "|---|---|---|---|",
    ]
    for k, name in enumerate(LABELS):
        unit, factor = ("m", 1.0) if name.endswith("_m") else ("deg", float(np.degrees(1.0)))
        error, constant = metrics["label_mae"][k] * factor, metrics["constant_mae"][k] * factor
        band = metrics["band_mae"][k] * factor
        figures = " | ".join(f"{value:.2f} {unit}" for value in (error, band, constant))
        lines.append(f"| {name.rsplit('_', 1)[0]} | {figures} |")
    return "\n".join(lines)


def _policy_table(metrics: dict[str, Any]) -> str:
    lines = [
        "| velocity | RMSE | of a constant | NLL | 90 % interval covers |",
        "|---|---|---|---|---|",
    ]
    for k, name in enumerate(VELOCITIES):
        rmse, constant = metrics["rmse"][k], metrics["constant_rmse"][k]
        nll = metrics["nll"][k]
        coverage = metrics["coverage"][k]
        lines.append(f"| {name} | {rmse:.3f} | {constant:.3f} | {nll:.2f} | {_percent(coverage)} |")
    return "\n".join(lines)
