"""Training of the detector: labels are where gates are, cells learn them, a folder flies."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from flightstack.errors import ModelError, UsageError
from flightstack.gate_models import is_gate_model, load_gate_model
from flightstack.perception.gate_decoding import DetectionCalibration, decode
from flightstack.training.commands.detector import write_model
from flightstack.training.detector.calibration import match, metrics_of
from flightstack.training.detector.losses import targets_of
from flightstack.training.detector.scenes import SceneRenderer, labels_of
from flightstack.training.detector.store import Scenes, make_scenes
from flightstack.training.detector.trainer import DetectorSettings, Epoch, train_detector, validate
from flightstack.training.recipe import Recipe
from sitl import Gate, quaternion_from_euler
from tests.paths import ROOT

SCENES = 48
RECIPE = Recipe.load("strong").scenes


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Scenes:
    return make_scenes(tmp_path_factory.mktemp("scenes"), RECIPE, [3], SCENES)


def gate(north: float, east: float, yaw_rad: float = 0.0) -> Gate:
    return Gate(index=0, centre_ned=(north, east, -2.0), yaw_rad=yaw_rad)


def test_labels_are_where_a_level_camera_sees_the_gates_the_nearest_first() -> None:
    level = quaternion_from_euler(0.0, 0.0, 0.0)
    gates = (gate(6.0, 3.0, 0.5), gate(3.0, 0.0), gate(-4.0, 0.0), gate(2.0, 5.0))
    labels = labels_of(gates, (0.0, 0.0, -2.0), level)
    assert labels[:, 2] == pytest.approx([3.0, math.hypot(6.0, 3.0)])  # behind, and out of view
    assert labels[:, 0] == pytest.approx([32.0, 48.0])
    assert labels[:, 1] == pytest.approx([32.0, 32.0])
    assert labels[:, 3] == pytest.approx([0.0, 0.5 - math.atan2(3.0, 6.0)], abs=1e-6)


def test_a_seed_gives_the_same_scenes() -> None:
    drawn = []
    for _ in range(2):
        renderer = SceneRenderer(RECIPE)
        rng = np.random.default_rng(5)
        drawn.append([renderer.draw(rng) for _ in range(3)])
        renderer.close()
    for (image, labels), (other, others) in zip(*drawn, strict=True):
        assert np.array_equal(image, other)
        assert np.array_equal(labels, others)


def test_scenes_of_another_recipe_are_refused(tmp_path: Path) -> None:
    make_scenes(tmp_path, RECIPE, [3], 2)
    other = replace(RECIPE, pair_share=0.0)
    with pytest.raises(UsageError, match="holds scenes of another recipe"):
        make_scenes(tmp_path, other, [3], 2)
    with pytest.raises(UsageError, match="holds 2 scenes, not 3"):
        make_scenes(tmp_path, RECIPE, [3], 3)


def test_scenes_hold_none_one_and_several_gates(scenes: Scenes) -> None:
    counts = np.isfinite(scenes.labels[:, :, 0]).sum(axis=1)
    assert len(scenes) == SCENES
    assert {0, 1, 2} <= set(counts.tolist())


def test_cells_that_say_what_is_wanted_are_decoded_to_the_labels(scenes: Scenes) -> None:
    targets = targets_of(torch.from_numpy(scenes.labels))
    cells = torch.full((SCENES, 10, 16, 16), -8.0)
    cells[:, 0][targets.is_gate] = 5.0
    cells[:, 1:6] = targets.values
    found = decode(cells[10].numpy(), DetectionCalibration())
    distances = scenes.labels[10, :, 2]
    wanted = np.sort(distances[np.isfinite(distances)])
    seen = np.sort(np.linalg.norm(found.position_frd, axis=1))
    assert len(seen) <= len(wanted)  # of two in one cell the nearer
    assert all(min(abs(one - wanted)) < 1e-3 for one in seen)


def test_a_short_training_learns_and_its_folder_can_be_flown(
    scenes: Scenes, tmp_path: Path
) -> None:
    torch.set_num_threads(1)
    epochs: list[Epoch] = []
    settings = DetectorSettings(epochs=4, batch=8, warm_up_steps=2)
    network = train_detector(scenes, scenes, settings, epochs.append)
    assert epochs[-1].score_loss < epochs[0].score_loss
    assert validate(network, scenes)[0] == pytest.approx(epochs[-1].score_loss)
    network.eval()
    metrics = metrics_of(match(network, scenes, DetectionCalibration(min_score=0.0)))
    assert metrics["bands"]
    folder = tmp_path / "strong" / "b9"
    write_model(folder, network, scenes, {"scenes": SCENES})
    assert json.loads((folder / "metrics.json").read_text())["trained"] == {"scenes": SCENES}
    assert is_gate_model(str(folder))
    loaded = load_gate_model(str(folder))
    one, other = (
        each.detect(scenes.images[0])
        for each in (loaded.detector, load_gate_model(str(folder)).detector)
    )
    assert np.array_equal(one.position_frd, other.position_frd)


def test_a_folder_that_is_damaged_or_of_another_kind_is_refused_in_one_line(
    tmp_path: Path,
) -> None:
    assert not is_gate_model("strong/m0")
    with pytest.raises(ModelError, match="unknown model"):
        is_gate_model("strong/b77")
    folder = tmp_path / "b0"
    folder.mkdir()
    config = (ROOT / "models/strong/b0/config.toml").read_text()
    (folder / "config.toml").write_text(config)
    (folder / "weights.safetensors").write_bytes(b"nothing of use")
    with pytest.raises(ModelError, match="damaged"):
        load_gate_model(str(folder))
    (folder / "config.toml").write_text(config.replace("speed_m_s = 2.6", "speed_m_s = 99.0"))
    with pytest.raises(ModelError, match="speed_m_s"):
        load_gate_model(str(folder))
