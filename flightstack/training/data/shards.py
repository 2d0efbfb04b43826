"""Write and read one shard: memory-mapped arrays, and a sidecar that is written last.

A shard is `NAME-images.npy` (K, 64, 64, 3) uint8 RGB, `NAME-labels.npy` (K, L) float32 and
`NAME.json` (count, split, hashes); one without its sidecar is unfinished, and made again.
"""

import hashlib
import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import RgbStack
from flightstack.errors import UsageError
from flightstack.files import write_whole

MAX_LABEL = {  # either way: beyond it the data are not what they claim
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
    settings_sha256: str  # of all that the dataset depends on


def write_shard(
    folder: Path,
    name: str,
    split: str,
    images: RgbStack,
    labels: Float32[NDArray[np.float32], "K L"],
    *,
    settings_sha256: str,
) -> None:
    """Write one shard, its sidecar last."""
    shard = Shard(
        name=name,
        split=split,
        count=len(images),
        images_sha256=_save(folder / f"{name}-images.npy", images),
        labels_sha256=_save(folder / f"{name}-labels.npy", labels),
        settings_sha256=settings_sha256,
    )
    write_whole(folder / f"{name}.json", json.dumps(asdict(shard)))


def is_finished(folder: Path, name: str) -> bool:
    """Whether the shard stands whole."""
    return (folder / f"{name}.json").exists()


def read_sidecar(folder: Path, name: str) -> Shard:
    """Read what a shard is; raises UsageError."""
    path = folder / f"{name}.json"
    try:
        return Shard(**json.loads(path.read_text()))
    except (OSError, TypeError, json.JSONDecodeError) as error:
        raise UsageError(f"{path}: missing or damaged; make the data again") from error


def read_shard(
    folder: Path, name: str, label_names: tuple[str, ...]
) -> tuple[Shard, RgbStack, Float32[NDArray[np.float32], "K L"]]:
    """Open a shard's images and labels; raises UsageError where they are damaged or implausible."""
    shard, path = read_sidecar(folder, name), folder / name
    images, labels = (_open(folder, name, kind) for kind in ("images", "labels"))
    if len(images) != shard.count or len(labels) != shard.count:
        raise UsageError(
            f"{path}: {len(images)} images and {len(labels)} labels, "
            f"{shard.count} expected; delete {name}.json and make the data again"
        )
    if not np.isfinite(labels).all():
        raise UsageError(f"{path}: labels are not finite; make the data again")
    for label, column in zip(label_names, labels.T, strict=True):
        limit = MAX_LABEL.get(label, math.inf)
        if (worst := float(np.abs(column).max(initial=0.0))) > limit * (1.0 + 1e-6):
            raise UsageError(
                f"{path}: label {label} is out of range, {worst:.4g} where {limit:.4g} is the "
                "most; make the data again"
            )
    return shard, images, labels


def _save(path: Path, array: NDArray[np.uint8] | NDArray[np.float32]) -> str:
    """Write an array; returns the hash of its bytes."""
    np.save(path, array)
    return hashlib.sha256(np.ascontiguousarray(array).data).hexdigest()


def _open(folder: Path, name: str, kind: str) -> Any:
    path = folder / f"{name}-{kind}.npy"
    try:
        return np.load(path, mmap_mode="r")
    except (OSError, ValueError) as error:
        raise UsageError(
            f"{path}: damaged or cut short; delete {name}.json and make the data again"
        ) from error
