"""Small synthetic data, coloured squares and their pose, and an encoder trained on them."""

from pathlib import Path

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from flightstack.networks.dronet import Dronet
from flightstack.perception.labels import LABELS
from flightstack.records import VELOCITIES
from flightstack.training.data.dataset import Dataset, ShardedImages
from flightstack.training.perception.trainer import PerceptionRun, train_perception
from flightstack.training.presets import PerceptionSettings


def draw_square(range_m: float, azimuth: float, elevation: float, yaw: float) -> NDArray[np.uint8]:
    """A square whose size, place and sideways shading tell the label."""
    rgb = np.full((64, 64, 3), 90, dtype=np.uint8)
    half = round(14.0 / range_m)
    column, row = round(32 + 40 * azimuth), round(32 - 40 * elevation)
    slope = np.linspace(-1.0, 1.0, 64) * yaw
    shade = np.clip(180.0 + 70.0 * slope, 0, 255).astype(np.uint8)
    rows, columns = (
        slice(max(0, row - half), row + half),
        slice(max(0, column - half), column + half),
    )
    rgb[rows, columns, 0] = shade[columns]
    rgb[rows, columns, 2] = 255 - shade[columns]
    return rgb


def make_dataset(
    names: tuple[str, ...], labels: NDArray[np.float32], poses: NDArray[np.float32]
) -> Dataset:
    images = np.stack([draw_square(*pose) for pose in poses])
    train = round(0.8 * len(images))
    return Dataset(
        folder=Path("synthetic"),
        images=ShardedImages([images]),
        labels=labels,
        label_names=names,
        splits={"train": np.arange(train), "validation": np.arange(train, len(images))},
        sha256="synthetic",
        manifest={},
    )


def draw_poses(seed: int, count: int) -> NDArray[np.float32]:
    low, high = (1.0, -0.5, -0.5, -1.0), (4.0, 0.5, 0.5, 1.0)
    return np.random.default_rng(seed).uniform(low, high, (count, 4)).astype(np.float32)


@pytest.fixture(scope="session")
def perception_data() -> Dataset:
    poses = draw_poses(0, 800)
    return make_dataset(LABELS, poses, poses)


@pytest.fixture(scope="session")
def control_data() -> Dataset:
    """Fly towards the square: the command is a linear function of its pose, plus noise."""
    poses = draw_poses(1, 800)
    gain = np.diag([0.3, 1.0, -1.0, 0.5])
    noise = np.random.default_rng(2).normal(0.0, 0.05, poses.shape)
    return make_dataset(VELOCITIES, (poses @ gain + noise).astype(np.float32), poses)


@pytest.fixture(scope="session")
def perception_run(
    perception_data: Dataset, tmp_path_factory: pytest.TempPathFactory
) -> PerceptionRun:
    torch.set_num_threads(1)
    settings = PerceptionSettings(epochs=12, batch=32, warmup_steps=10, learning_rate=2e-3)
    folder = tmp_path_factory.mktemp("runs") / "perception-mcd-0"
    device = torch.device("cpu")
    return train_perception(perception_data, settings, folder, device=device, report=lambda _: None)


@pytest.fixture(scope="session")
def encoder(perception_run: PerceptionRun) -> Dronet:
    return perception_run.model.encoder
