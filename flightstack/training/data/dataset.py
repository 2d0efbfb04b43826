"""Datasets of images and labels: shards of memory-mapped arrays and one manifest.

A folder holds, for every shard, `NAME-images.npy` (K, 64, 64, 3) uint8 RGB, `NAME-labels.npy`
(K, L) float32 and `NAME.json` (count, split, hashes), written last: a shard without it is made
again. `manifest.json` names the shards, the seed and the recipe that gave them, and the
statistics of every label. The same seed and recipe give the same bytes, on any number of cores.
"""

import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.files import write_whole

MANIFEST = "manifest.json"
MOST = {  # that a label can be, either way: beyond it the data are not what they claim
    "range_m": 100.0,
    "azimuth_rad": math.pi,
    "elevation_rad": math.pi / 2,
    "gate_yaw_rad": math.pi,
    "vx": 20.0,  # m/s, as the next two
    "vy": 20.0,
    "vz": 20.0,
    "yaw_rate": 2 * math.pi,  # rad/s
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Shard:
    """One finished shard as its sidecar file describes it."""

    name: str
    split: str
    count: int
    images_sha256: str
    labels_sha256: str
    settings_sha256: str = ""  # of all that the dataset depends on; empty in old folders


class ShardedImages:
    """All images of a dataset as one array of shape (K, 64, 64, 3), read from the shards' maps."""

    def __init__(self, parts: list[NDArray[np.uint8]]) -> None:
        self.parts = parts
        self._starts = np.cumsum([0] + [len(part) for part in parts])

    def __len__(self) -> int:
        """Give the number of images."""
        return int(self._starts[-1])

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the whole."""
        return (len(self), *self.parts[0].shape[1:])

    def __getitem__(self, indices: NDArray[np.integer[Any]] | slice) -> NDArray[np.uint8]:
        """Gather images by an index array or a slice, in the order asked for."""
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
    images: ShardedImages  # (K, 64, 64, 3) uint8 RGB
    labels: NDArray[np.float32]  # (K, L)
    label_names: tuple[str, ...]
    splits: dict[str, NDArray[np.int64]]  # indices of each split
    sha256: str
    manifest: dict[str, Any]


def write_shard(
    folder: Path,
    name: str,
    split: str,
    images: NDArray[np.uint8],
    labels: NDArray[np.float32],
    *,
    settings_sha256: str,
) -> None:
    """Write one shard, its sidecar last, so that an interrupted one is seen to be unfinished."""
    hashes = {}
    for kind, array in (("images", images), ("labels", labels)):
        np.save(folder / f"{name}-{kind}.npy", array)
        hashes[f"{kind}_sha256"] = hashlib.sha256(np.ascontiguousarray(array).data).hexdigest()
    sidecar = {"name": name, "split": split, "count": len(images), **hashes}
    sidecar["settings_sha256"] = settings_sha256
    write_whole(folder / f"{name}.json", json.dumps(sidecar))


def is_finished(folder: Path, name: str) -> bool:
    """Whether the shard stands whole."""
    return (folder / f"{name}.json").exists()


def settings_sha256(about: dict[str, Any]) -> str:
    """Hash what a dataset depends on."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def refuse_other(folder: Path, about: dict[str, Any], counts: dict[str, int]) -> None:
    """Raise UsageError where a folder holds anything but a part of the dataset that is described.

    `counts` says how many images each shard will hold.
    """
    advice = "choose another folder, or remove this one"
    if known := (folder / MANIFEST).exists():
        manifest = json.loads((folder / MANIFEST).read_text())
        found, wanted = (_flat({key: m.get(key) for key in about}) for m in (manifest, about))
        if other := sorted(k for k in found | wanted if found.get(k) != wanted.get(k)):
            raise UsageError(f"{folder} holds data made with another {', '.join(other)}: {advice}")
    settings = settings_sha256(about)
    for path in sorted(folder.glob("*-*.json")):
        shard = _read_sidecar(folder, path.stem)
        if shard.settings_sha256 != settings and (shard.settings_sha256 or not known):
            raise UsageError(
                f"{folder} holds {shard.name}, made with another recipe, seed or settings: {advice}"
            )
        if shard.count != counts.get(shard.name, shard.count):
            raise UsageError(
                f"{folder} holds {shard.count} images as {shard.name}, not {counts[shard.name]}, "
                f"of a dataset of another size: {advice}"
            )


def _flat(about: dict[str, Any]) -> dict[str, Any]:
    """Plain JSON values, those of nested tables beside the others."""
    plain = json.loads(json.dumps(about))
    nested = {k: v for table in plain.values() if isinstance(table, dict) for k, v in table.items()}
    return {**{k: v for k, v in plain.items() if not isinstance(v, dict)}, **nested}


def write_manifest(
    folder: Path, names: list[str], *, label_names: tuple[str, ...], about: dict[str, Any]
) -> None:
    """Close a dataset: gather the sidecars of `names`, label statistics and one hash of it all."""
    shards = [_read_sidecar(folder, name) for name in names]
    labels = np.concatenate([np.load(folder / f"{name}-labels.npy") for name in names])
    digest = hashlib.sha256("".join(s.images_sha256 + s.labels_sha256 for s in shards).encode())
    statistics = {
        label: {
            "mean": float(column.mean()),
            "std": float(column.std()),
            "min": float(column.min()),
            "max": float(column.max()),
        }
        for label, column in zip(label_names, labels.T.astype(np.float64), strict=True)
    }
    manifest = {
        **about,
        "count": len(labels),
        "sha256": digest.hexdigest(),
        "label_names": list(label_names),
        "label_statistics": statistics,
        "shards": [s.name for s in shards],
    }
    (folder / MANIFEST).write_text(json.dumps(manifest, indent=2) + "\n")


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
    parts, labels = [], []
    splits: dict[str, list[NDArray[np.int64]]] = {}
    start = 0
    for shard, images_part, labels_part in _read_shards(folder, manifest["shards"]):
        _refuse_out_of_range(folder / shard.name, labels_part, manifest["label_names"])
        parts.append(images_part)
        labels.append(labels_part)
        splits.setdefault(shard.split, []).append(np.arange(start, start + shard.count))
        start += shard.count
    return Dataset(
        folder=folder,
        images=ShardedImages(parts),
        labels=np.concatenate(labels),
        label_names=tuple(manifest["label_names"]),
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


def _read_shards(
    folder: Path, names: list[str]
) -> Iterator[tuple[Shard, NDArray[np.uint8], NDArray[np.float32]]]:
    for name in names:
        shard = _read_sidecar(folder, name)
        arrays = []
        for kind in ("images", "labels"):
            path = folder / f"{name}-{kind}.npy"
            try:
                arrays.append(np.load(path, mmap_mode="r"))
            except (OSError, ValueError) as error:
                raise UsageError(
                    f"{path}: damaged or cut short; delete {name}.json and make the data again"
                ) from error
        images, labels = arrays
        if len(images) != shard.count or len(labels) != shard.count:
            raise UsageError(
                f"{folder / name}: {len(images)} images and {len(labels)} labels, "
                f"{shard.count} expected; delete {name}.json and make the data again"
            )
        if not np.isfinite(labels).all():
            raise UsageError(f"{folder / name}: labels are not finite; make the data again")
        yield shard, images, labels


def _refuse_out_of_range(path: Path, labels: NDArray[np.float32], names: list[str]) -> None:
    for name, column in zip(names, labels.T, strict=True):
        most = MOST.get(name, math.inf)
        if (worst := float(np.abs(column).max(initial=0.0))) > most * (1.0 + 1e-6):
            raise UsageError(
                f"{path}: label {name} is out of range, {worst:.4g} where {most:.4g} is the most; "
                "make the data again"
            )


def _read_sidecar(folder: Path, name: str) -> Shard:
    path = folder / f"{name}.json"
    try:
        return Shard(**json.loads(path.read_text()))
    except (OSError, TypeError, json.JSONDecodeError) as error:
        raise UsageError(f"{path}: missing or damaged; make the data again") from error
