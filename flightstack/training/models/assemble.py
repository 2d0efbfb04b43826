"""Put a model's folder together from finished trainings: weights, configuration, card, metrics."""

import json
import subprocess
from pathlib import Path
from typing import Any

from safetensors.torch import save_file

from flightstack import __version__
from flightstack.files import write_whole
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, ModelConfig, file_sha256
from flightstack.perception.config import PerceptionConfig
from flightstack.policy.config import PolicyConfig
from flightstack.policy.scales import VelocityRange
from flightstack.tables import table_text
from flightstack.training.models.card import model_card
from flightstack.training.models.catalogue import ModelPlan
from flightstack.training.models.flight_form import export
from flightstack.training.recipe import RECIPE_FILE, Recipe
from flightstack.training.runs import FinishedRun

CARD_FILE, METRICS_FILE = "README.md", "metrics.json"


def write_model(
    folder: Path,
    plan: ModelPlan,
    perception: FinishedRun,
    policy: FinishedRun,
    *,
    recipe: Recipe,
    preset: str,
) -> None:
    """Write <recipe>/<name> and its flight form; the image decoder stays behind."""
    folder.mkdir(parents=True, exist_ok=True)
    flies = ("encoder.", "pose_decoder.")
    weights = {key: value for key, value in perception.weights.items() if key.startswith(flies)}
    weights |= {f"policies.{key}": value for key, value in policy.weights.items()}
    save_file(weights, folder / WEIGHTS_FILE)
    (folder / WEIGHTS_FILE).chmod(0o644)  # safetensors keeps its files from other users
    config = ModelConfig(
        name=folder.name,
        recipe=recipe.name,
        strategy=plan.strategy,
        weights_sha256=file_sha256(folder / WEIGHTS_FILE),
        perception=PerceptionConfig(
            latent_dims=perception.summary["latent_dims"],
            dropout=perception.summary["dropout"],
            sampling=plan.sampling,
            samples=plan.samples,
            label_scale=perception.label_scale,
        ),
        policy=policy_config(policy.summary),
    )
    write_whole(folder / RECIPE_FILE, recipe.text())
    describe_model(folder, config, plan, _metrics(perception, policy, preset))
    export(str(folder), report=lambda _: None)


def describe_model(
    folder: Path, config: ModelConfig, plan: ModelPlan, metrics: dict[str, Any]
) -> None:
    """Write what stands beside a model's weights: configuration, metrics and card."""
    write_whole(folder / CONFIG_FILE, table_text(config))
    write_whole(folder / METRICS_FILE, json.dumps(metrics, indent=2) + "\n")
    write_whole(folder / CARD_FILE, model_card(config, plan, metrics))


def policy_config(summary: dict[str, Any]) -> PolicyConfig:
    """Read the shape of a stack from its run's summary."""
    limits = summary["velocity_range"]
    return PolicyConfig(
        members=summary["members"],
        probabilistic=summary["probabilistic"],
        hidden=tuple(summary["hidden"]),
        mixture=summary["mixture"],
        velocity_range=VelocityRange(low=tuple(limits["low"]), high=tuple(limits["high"])),
        variance_factor=tuple(summary["metrics"]["variance_factor"]),
        best_member=tuple(summary["metrics"]["best_member"]),
    )


def _metrics(perception: FinishedRun, policy: FinishedRun, preset: str) -> dict[str, Any]:
    return {
        "trained": {
            "preset": preset,
            "commit": _commit(),
            "perception_seed": perception.summary["seed"],
            "perception_data_sha256": perception.summary["data"],
            "policy_seed": policy.summary["seed"],
            "policy_data_sha256": policy.summary["data"],
        },
        "perception": perception.summary["metrics"],
        "policy": policy.summary["metrics"],
    }


def _commit() -> str:
    """Name the commit of the code that runs, or its version where there is no repository."""
    command = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    try:
        found = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    except (OSError, subprocess.CalledProcessError):
        return f"flightstack {__version__}"
    return found.stdout.strip()
