from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flightstack.errors import UsageError
from flightstack.training.commands.cli import main
from flightstack.training.data import pictures
from flightstack.training.data.dataset import Dataset
from flightstack.training.data.manifest import write_manifest
from flightstack.training.data.shards import write_shard
from tests.pictures import pixels


def write(folder: Path, source: Dataset) -> None:
    names = []
    for split, indices in source.splits.items():
        arrays = source.images[indices], source.labels[indices]
        write_shard(folder, f"{split}-00000", split, *arrays, settings_sha256="")
        names.append(f"{split}-00000")
    write_manifest(folder, names, label_names=source.label_names, about={})


@pytest.mark.parametrize("kind", ["perception_data", "control_data"])
def test_looking_writes_a_sheet_and_histograms(
    kind: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    write(tmp_path, request.getfixturevalue(kind))
    assert main(["data", "look", str(tmp_path)]) == 0
    sheet = pixels(tmp_path / "look" / "sheet.png")
    assert sheet.shape == (pictures.ROWS * pictures.SIDE, pictures.COLUMNS * pictures.SIDE, 3)
    histograms = pixels(tmp_path / "look" / "histograms.png")
    assert histograms.std() > 5.0


def test_ring_stands_where_the_label_says() -> None:
    picture = np.zeros((pictures.SIDE, pictures.SIDE, 3), dtype=np.uint8)
    pictures.draw_pose(picture, np.array([4.0, np.pi / 8, 0.0, 0.0], dtype=np.float32))
    rows, columns = np.nonzero((picture == pictures.RING).all(axis=2))
    assert rows.mean() == pytest.approx(pictures.SIDE / 2, abs=1.0)
    assert columns.mean() == pytest.approx(pictures.SIDE / 2 * (1.0 + np.tan(np.pi / 8)), abs=1.5)


def test_higher_and_to_the_left_is_up_and_left() -> None:
    column, row = pictures.pixel(np.array([1.0, -0.5, -0.5]))
    assert (column, row) == (pictures.SIDE // 4, pictures.SIDE // 4)


def test_arrow_points_where_the_command_flies() -> None:
    picture = np.zeros((pictures.SIDE, pictures.SIDE, 3), dtype=np.uint8)
    pictures.draw_command(picture, np.array([3.5, 1.5, 0.0, 0.0], dtype=np.float32))
    rows, columns = np.nonzero((picture == pictures.ARROW).all(axis=2))
    assert rows.min() == pytest.approx(pictures.SIDE / 4, abs=3)
    assert columns.max() == pytest.approx(pictures.SIDE * 0.75, abs=3)


def test_unknown_labels_are_refused(control_data: Dataset, tmp_path: Path) -> None:
    write(tmp_path, replace(control_data, label_names=("a", "b", "c", "d")))
    with pytest.raises(UsageError, match="labels a, b, c, d cannot be drawn"):
        pictures.write_pictures(tmp_path, tmp_path / "look", seed=0)
