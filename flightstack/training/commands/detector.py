"""Train a gate detector, calibrate it, and write the folder of a model that flies by a belief."""

import json
from pathlib import Path

from safetensors.torch import save_file

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.gate_models import GateModelConfig
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, file_sha256
from flightstack.networks.gate_network import GateNetwork
from flightstack.tables import table_text
from flightstack.training.detector.calibration import calibrate, match, metrics_of
from flightstack.training.detector.store import (
    FILE_SCENES,
    VALIDATION_SCENES,
    Scenes,
    make_scenes,
)
from flightstack.training.detector.trainer import DetectorSettings, Epoch, train_detector
from flightstack.training.models.flight_form import export
from flightstack.training.progress import Curves
from flightstack.training.recipe import RECIPE_FILE, Recipe
from flightstack.training.seeds import TRAINING_SCENES
from flightstack.training.seeds import VALIDATION_SCENES as VALIDATION_SEEDS

FILES = 2  # of scenes, where neither options nor recipe say
FIELD_OF_VIEW_DEG = 90.0  # that its cells are made for
STRATEGY, SPEED_M_S = "de-mean", 2.6


def train(out: Path, data: Path, recipe: Recipe, *, files: int, settings: DetectorSettings) -> None:
    """Make what scenes are missing, in DATA/RECIPE, train, calibrate, write.

    Raises UsageError where scenes of another recipe are there.
    """
    if recipe.scenes.scenery.field_of_view_deg != FIELD_OF_VIEW_DEG:
        raise UsageError(
            f"recipe {recipe.name}: a detector takes images of {FIELD_OF_VIEW_DEG:g} degrees, not "
            f"{recipe.scenes.scenery.field_of_view_deg:g}: leave field_of_view_deg out"
        )
    folder, training = data / recipe.name, recipe.training
    count = training.file_scenes or FILE_SCENES
    scenes = make_scenes(folder / "scenes", recipe.scenes, TRAINING_SCENES[:files], count)
    count = training.validation_scenes or VALIDATION_SCENES
    validation = make_scenes(folder / "validation-scenes", recipe.scenes, VALIDATION_SEEDS, count)
    out.mkdir(parents=True, exist_ok=True)
    curves = Curves(out, done=0, epochs=settings.epochs)

    def say(epoch: Epoch) -> None:
        left = curves.add(epoch.number, score_loss=epoch.score_loss, value_loss=epoch.value_loss)
        print(
            f"epoch {epoch.number}/{settings.epochs}, {left} left: "
            f"validation {epoch.score_loss:.4f} {epoch.value_loss:.4f}"
        )

    network = train_detector(scenes, validation, settings, say)
    trained = {
        "scenes": len(scenes),
        "scene_seeds": [TRAINING_SCENES[0], TRAINING_SCENES[files - 1]],
        "epochs": settings.epochs,
        "seed": settings.seed,
    }
    write_model(out, network, validation, trained)
    write_whole(out / RECIPE_FILE, recipe.text())


def write_model(
    out: Path, network: GateNetwork, validation: Scenes, trained: dict[str, object]
) -> None:
    """Calibrate a network, and write its folder; `trained` says how it came about."""
    out.mkdir(parents=True, exist_ok=True)
    weights = out / WEIGHTS_FILE
    save_file({k: v.contiguous() for k, v in network.state_dict().items()}, weights)
    calibration = calibrate(network, validation)
    metrics = metrics_of(match(network, validation, calibration))
    metrics["trained"] = trained
    write_whole(out / "metrics.json", json.dumps(metrics, indent=1) + "\n")
    config = GateModelConfig(
        name=out.name,
        recipe=out.parent.name,
        strategy=STRATEGY,
        weights_sha256=file_sha256(weights),
        speed_m_s=SPEED_M_S,
        detector=calibration,
    )
    write_whole(out / CONFIG_FILE, table_text(config))
    export(str(out))
