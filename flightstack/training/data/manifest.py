"""Close a dataset with a manifest of what it holds, and refuse a folder that holds another.

`manifest.json` names the shards, the seed and the recipe that gave them, and the statistics of
every label. The same seed and recipe give the same bytes, on any number of cores.
"""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.training.data.shards import read_sidecar

MANIFEST = "manifest.json"


def settings_sha256(about: dict[str, Any]) -> str:
    """Hash what a dataset depends on."""
    return hashlib.sha256(json.dumps(about, sort_keys=True).encode()).hexdigest()


def refuse_other(folder: Path, about: dict[str, Any], counts: dict[str, int]) -> None:
    """Raise UsageError where a folder holds anything but a part of the dataset that is described.

    `counts` says how many images each shard will hold.
    """
    advice = "choose another folder, or remove this one"
    if (folder / MANIFEST).exists():
        manifest = json.loads((folder / MANIFEST).read_text())
        found, wanted = (_flat({key: m.get(key) for key in about}) for m in (manifest, about))
        if other := sorted(k for k in found | wanted if found.get(k) != wanted.get(k)):
            raise UsageError(f"{folder} holds data made with another {', '.join(other)}: {advice}")
    settings = settings_sha256(about)
    for path in sorted(folder.glob("*-*.json")):
        shard = read_sidecar(folder, path.stem)
        if shard.settings_sha256 != settings:
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
    shards = [read_sidecar(folder, name) for name in names]
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
    write_whole(folder / MANIFEST, json.dumps(manifest, indent=2) + "\n")
