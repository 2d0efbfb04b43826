import dataclasses
import json
from pathlib import Path

import pytest
import torch

from flightstack.errors import UsageError
from flightstack.networks.trained import load_trained
from flightstack.training.data.dataset import Dataset
from flightstack.training.errors import TrainingError
from flightstack.training.perception.metrics import PerceptionMetrics
from flightstack.training.perception.start import Start
from flightstack.training.perception.trainer import (
    PerceptionRun,
    PerceptionTrainer,
    train_perception,
)
from flightstack.training.presets import PerceptionSettings
from flightstack.training.runs import read_run
from tests.pictures import pixels

CPU = torch.device("cpu")
SETTINGS = PerceptionSettings(epochs=3, batch=32, warmup_steps=10, learning_rate=2e-3)


def train(data: Dataset, folder: Path, settings: PerceptionSettings = SETTINGS) -> PerceptionRun:
    return train_perception(data, settings, folder, device=CPU, report=lambda _: None)


def test_every_label_is_learned(perception_run: PerceptionRun) -> None:
    assert max(perception_run.metrics.error_ratios) < 0.6
    assert perception_run.metrics.active_units >= 5


def test_run_can_be_read_again(perception_run: PerceptionRun) -> None:
    finished = read_run(perception_run.folder)
    assert finished.label_scale == perception_run.scale
    image = torch.zeros(1, 3, 64, 64)
    with torch.inference_mode():
        expected, found = perception_run.model.encoder(image)[0], finished.encoder()(image)[0]
    torch.testing.assert_close(found, expected)


def test_run_leaves_pictures_and_figures(perception_run: PerceptionRun) -> None:
    assert pixels(perception_run.folder / "reconstructions.png").shape[:2] == (256, 1536)
    assert pixels(perception_run.folder / "traversals.png").shape[:2] == (1280, 1408)
    summary = json.loads((perception_run.folder / "perception.json").read_text())
    assert summary["data"] == "synthetic"
    assert summary["metrics"]["active_units"] == perception_run.metrics.active_units


def test_interrupted_training_resumes_to_the_same_result(
    perception_data: Dataset, tmp_path: Path
) -> None:
    lines: list[str] = []

    def stop_after_two(line: str) -> None:
        lines.append(line)
        if len(lines) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_perception(
            perception_data, SETTINGS, tmp_path / "cut", device=CPU, report=stop_after_two
        )
    results = []
    for name in ("cut", "whole"):
        with pytest.raises(TrainingError):  # 3 epochs are too few to pass
            train(perception_data, tmp_path / name)
        results.append(read_run(tmp_path / name))
    assert results[0].sha256 == results[1].sha256


def test_nan_in_the_loss_is_a_clear_error(perception_data: Dataset, tmp_path: Path) -> None:
    settings = dataclasses.replace(SETTINGS, learning_rate=1e20, warmup_steps=1)
    with pytest.raises(TrainingError, match=r"the loss is (nan|inf) in epoch 1: lower"):
        train(perception_data, tmp_path, settings)
    assert not (tmp_path / "checkpoint.pt").exists()


HEALTHY = PerceptionMetrics(
    images=1,
    image_mse=0.1,
    label_mae=(0.5, 0.1, 0.1, 0.1),
    constant_mae=(2.0, 0.4, 0.4, 0.4),
    band_mae=(0.3, 0.05, 0.05, 0.05),
    kl=(1.0,) * 10,
    activity=(1.0,) * 10,
)


@pytest.mark.parametrize("dead", [0, 5])  # of ten latents; with six it collapsed
def test_healthy_network_passes(dead: int) -> None:
    metrics = dataclasses.replace(HEALTHY, activity=(1.0,) * (10 - dead) + (0.002,) * dead)
    metrics.require_healthy()
    assert metrics.active_units == 10 - dead


def test_collapse_of_the_posterior_is_a_clear_error() -> None:
    metrics = dataclasses.replace(HEALTHY, activity=(1.0,) * 4 + (0.002,) * 6)
    with pytest.raises(TrainingError, match="posterior collapsed: 4 active latent units"):
        metrics.require_healthy()


def test_label_no_better_than_a_constant_is_a_clear_error() -> None:
    metrics = dataclasses.replace(HEALTHY, label_mae=(0.5, 0.1, 0.1, 0.39))
    with pytest.raises(TrainingError, match="label gate_yaw_rad was not learned"):
        metrics.require_healthy()


def test_label_that_is_not_a_number_is_a_clear_error() -> None:
    metrics = dataclasses.replace(HEALTHY, label_mae=(float("nan"), 0.1, 0.1, 0.1))
    with pytest.raises(TrainingError, match="label range_m was not learned"):
        metrics.require_healthy()


def test_control_data_is_refused(control_data: Dataset, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="needs the labels"):
        train(control_data, tmp_path)


def test_table_speaks_degrees() -> None:
    line = "azimuth_rad: error 5.73 deg (2.86 deg from 1.5 to 8.0 m), constant 22.92 deg"
    assert line in HEALTHY.table()
    assert "range_m: error 0.50 m" in HEALTHY.table()


def test_a_training_goes_on_from_a_run_and_from_a_model_that_has_no_image_decoder(
    perception_run: PerceptionRun, perception_data: Dataset
) -> None:
    settings = PerceptionSettings(epochs=1, batch=32)
    device = torch.device("cpu")
    from_run = Start.find(str(perception_run.folder))
    trainer = PerceptionTrainer(perception_data, settings, device, from_run)
    assert trainer.scale == perception_run.scale
    assert trainer.weights.image == settings.weights.image
    found = trainer.measure().label_mae
    assert found == pytest.approx(perception_run.metrics.label_mae, rel=1e-5)
    from_model = Start.find("strong/m0")
    other = PerceptionTrainer(perception_data, settings, device, from_model)
    assert other.weights.image == 0.0
    image = torch.zeros(1, 3, 64, 64)
    with torch.inference_mode():
        expected = load_trained("strong/m0").encoder(image)[0]
        torch.testing.assert_close(other.model.eval().encoder(image)[0], expected)
    with pytest.raises(UsageError, match="does not fit: train with the same latent_dims"):
        PerceptionTrainer(
            perception_data, dataclasses.replace(settings, latent_dims=7), device, from_run
        )
