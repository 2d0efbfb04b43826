"""Read a finished dataset of images and labels, or several as one."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32, UInt8
from numpy.typing import NDArray

from flightstack.arrays import RgbStack
from flightstack.errors import UsageError
from flightstack.training.data.manifest import MANIFEST
from flightstack.training.data.shards import read_shard


class ShardedImages:
    """All images of a dataset as one array, read from the shards' maps."""

    def __init__(self, parts: list[UInt8[NDArray[np.uint8], "_ 64 64 3"]]) -> None:
        self.parts = parts
        self._starts = np.cumsum([0] + [len(part) for part in parts])

    def __len__(self) -> int:
        """Give the number of images."""
        return int(self._starts[-1])

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the whole."""
        return (len(self), *self.parts[0].shape[1:])

    def __getitem__(self, indices: NDArray[np.integer[Any]] | slice) -> RgbStack:
        """Gather images by an index array or a slice, in their order."""
        if isinstance(indices, slice):
            indices = np.arange(*indices.indices(len(self)))
        owners = np.searchsorted(self._starts, indices, side="right") - 1
        images = np.empty((len(indices), *self.parts[0].shape[1:]), dtype=np.uint8)
        for owner in np.unique(owners):
            mine = owners == owner
            images[mine] = self.parts[owner][indices[mine] - self._starts[owner]]
        return images


@dataclass(frozen=True, slots=True, kw_only=True)
class Dataset:
    """A finished dataset, opened for reading."""

    folder: Path
    images: ShardedImages
    labels: Float32[NDArray[np.float32], "K L"]
    label_names: tuple[str, ...]
    splits: dict[str, NDArray[np.int64]]  # indices of each split
    sha256: str
    manifest: dict[str, Any]


def read_dataset(folder: Path) -> Dataset:
    """Open a finished dataset.

    Raises:
        UsageError: the folder holds none, a shard is cut short, or labels are not finite or out of
            range.

    """
    manifest_path = folder / MANIFEST
    if not manifest_path.exists():
        raise UsageError(
            f"{folder}: no dataset here ({MANIFEST} is missing); "
            "make one with 'python -m flightstack.training data'"
        )
    manifest = json.loads(manifest_path.read_text())
    label_names = tuple(manifest["label_names"])
    parts, labels = [], []
    splits: dict[str, list[NDArray[np.int64]]] = {}
    start = 0
    for name in manifest["shards"]:
        shard, images_part, labels_part = read_shard(folder, name, label_names)
        parts.append(images_part)
        labels.append(labels_part)
        splits.setdefault(shard.split, []).append(np.arange(start, start + shard.count))
        start += shard.count
    return Dataset(
        folder=folder,
        images=ShardedImages(parts),
        labels=np.concatenate(labels),
        label_names=label_names,
        splits={name: np.concatenate(indices) for name, indices in splits.items()},
        sha256=manifest["sha256"],
        manifest=manifest,
    )


def join(datasets: list[Dataset]) -> Dataset:
    """Read several datasets as one, such as an expert's flights and rounds of DAgger.

    Raises UsageError when their labels differ.
    """
    first = datasets[0]
    if len(datasets) == 1:
        return first
    starts = np.cumsum([0] + [len(one.images) for one in datasets])
    splits: dict[str, list[NDArray[np.int64]]] = {}
    for one, start in zip(datasets, starts[:-1], strict=True):
        if one.label_names != first.label_names:
            raise UsageError(f"{one.folder} has other labels than {first.folder}: not joined")
        for name, indices in one.splits.items():
            splits.setdefault(name, []).append(indices + start)
    return Dataset(
        folder=first.folder,
        images=ShardedImages([part for one in datasets for part in one.images.parts]),
        labels=np.concatenate([one.labels for one in datasets]),
        label_names=first.label_names,
        splits={name: np.concatenate(parts) for name, parts in splits.items()},
        sha256=hashlib.sha256("".join(one.sha256 for one in datasets).encode()).hexdigest(),
        manifest={"joined": [one.manifest for one in datasets]},
    )
