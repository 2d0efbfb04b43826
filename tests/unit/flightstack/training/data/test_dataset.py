from pathlib import Path

import numpy as np
import pytest

from flightstack.errors import UsageError
from flightstack.training.data import dataset, generation
from flightstack.training.data.manifest import write_manifest
from flightstack.training.data.shards import write_shard
from flightstack.training.recipe import Recipe

STRONG = Recipe.load("strong")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    folder = tmp_path / "views"
    generation.generate_perception(folder, STRONG, images=40, seed=3, jobs=1, report=lambda _: None)
    return folder


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(
    folder: Path, tmp_path: Path
) -> None:
    again = generation.generate_perception(
        tmp_path / "again", STRONG, images=40, seed=3, jobs=1, report=lambda _: None
    )
    other = generation.generate_perception(
        tmp_path / "other", STRONG, images=40, seed=4, jobs=1, report=lambda _: None
    )
    first = dataset.read_dataset(folder)
    assert first.sha256 == dataset.read_dataset(again).sha256
    assert first.sha256 != dataset.read_dataset(other).sha256


def test_splits_share_nothing_and_cover_all(folder: Path) -> None:
    opened = dataset.read_dataset(folder)
    train, validation = opened.splits["train"], opened.splits["validation"]
    assert len(train) == 32
    assert len(validation) == 8
    assert sorted([*train, *validation]) == list(range(40))
    assert not np.array_equal(opened.images[train[:8]], opened.images[validation])


def test_an_unfinished_shard_is_made_again_and_a_finished_one_kept(folder: Path) -> None:
    before = dataset.read_dataset(folder).sha256
    kept = (folder / "train-00000.json").stat().st_mtime_ns
    (folder / "validation-00000.json").unlink()
    generation.generate_perception(folder, STRONG, images=40, seed=3, jobs=1, report=lambda _: None)
    assert dataset.read_dataset(folder).sha256 == before
    assert (folder / "train-00000.json").stat().st_mtime_ns == kept


def test_a_shard_cut_short_is_named(folder: Path) -> None:
    path = folder / "train-00000-images.npy"
    path.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(UsageError, match="train-00000-images"):
        dataset.read_dataset(folder)


def test_labels_that_are_not_finite_are_refused(folder: Path) -> None:
    path = folder / "train-00000-labels.npy"
    labels = np.load(path)
    labels[3, 1] = np.nan
    np.save(path, labels)
    with pytest.raises(UsageError, match="not finite"):
        dataset.read_dataset(folder)


def test_labels_out_of_range_are_named(folder: Path) -> None:
    path = folder / "train-00000-labels.npy"
    labels = np.load(path)
    labels[3, 1] = 57.0  # degrees, where radians are meant
    np.save(path, labels)
    with pytest.raises(UsageError, match=r"label azimuth_rad is out of range, 57 where 3\.142"):
        dataset.read_dataset(folder)


def test_a_folder_without_data_says_how_to_make_some(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="training data"):
        dataset.read_dataset(tmp_path)


def test_images_are_gathered_across_shards(tmp_path: Path) -> None:
    images = np.arange(5 * 64 * 64 * 3, dtype=np.uint32).astype(np.uint8).reshape(5, 64, 64, 3)
    labels = np.arange(10, dtype=np.float32).reshape(5, 2)
    write_shard(tmp_path, "a", "train", images[:2], labels[:2], settings_sha256="")
    write_shard(tmp_path, "b", "train", images[2:], labels[2:], settings_sha256="")
    write_manifest(tmp_path, ["a", "b"], label_names=("p", "q"), about={})
    opened = dataset.read_dataset(tmp_path)
    order = np.array([4, 0, 2, 1])
    assert np.array_equal(opened.images[order], images[order])
    assert np.array_equal(opened.images[1:4], images[1:4])
    assert np.array_equal(opened.labels, labels)


def generate(folder: Path, *, recipe: Recipe = STRONG, seed: int = 3, images: int = 40) -> Path:
    return generation.generate_perception(
        folder, recipe, images=images, seed=seed, jobs=1, report=lambda _: None
    )


def test_a_folder_of_other_data_is_refused(folder: Path) -> None:
    with pytest.raises(UsageError, match="made with another seed: choose another folder"):
        generate(folder, seed=4)
    with pytest.raises(UsageError, match=r"made with another .*range_m, .*recipe"):
        generate(folder, recipe=Recipe.load("paper"))
    with pytest.raises(UsageError, match="of a dataset of another size"):
        generate(folder, images=50)


def test_shards_of_other_data_are_refused_before_there_is_a_manifest(folder: Path) -> None:
    (folder / "manifest.json").unlink()
    (folder / "validation-00000.json").unlink()
    with pytest.raises(UsageError, match="holds train-00000, made with another recipe, seed or"):
        generate(folder, seed=4)
    assert not (folder / "validation-00000.json").exists()


def test_datasets_are_read_as_one(folder: Path, tmp_path: Path) -> None:
    parts = [dataset.read_dataset(folder), dataset.read_dataset(generate(tmp_path / "b", seed=5))]
    joined = dataset.join(parts)
    assert len(joined.images) == len(joined.labels) == 80
    for split in ("train", "validation"):
        expected = np.concatenate([p.images[p.splits[split]] for p in parts])
        assert np.array_equal(joined.images[joined.splits[split]], expected)
    assert joined.sha256 not in {p.sha256 for p in parts}
    assert dataset.join(parts[:1]) is parts[0]
