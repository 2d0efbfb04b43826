"""Scenes in files, each of its own seed: made once, read as often as they are trained on.

A file names what it was drawn from, and is refused where something else is asked for.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import RgbStack
from flightstack.errors import UsageError
from flightstack.training.data.manifest import settings_sha256
from flightstack.training.detector.scenes import SceneRenderer
from flightstack.training.scene_recipe import SceneRecipe

FILE_SCENES = 40_000
VALIDATION_SCENES = 4_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenes:
    """K images, and up to G gates in each, NaN where there are fewer."""

    images: RgbStack
    labels: Float32[NDArray[np.float32], "K G 4"]

    def __len__(self) -> int:
        """Return K."""
        return len(self.images)


def make_scenes(folder: Path, recipe: SceneRecipe, seeds: Sequence[int], count: int) -> Scenes:
    """Read the scenes of these seeds, so many of each; those that are missing are made first.

    Raises UsageError where a file holds scenes of another recipe, or another number of them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{seed:06}.npz" for seed in seeds]
    missing = [(recipe, seed, count, path) for seed, path in zip(seeds, paths, strict=True)
               if not path.is_file()]  # fmt: skip
    if missing:
        with ProcessPoolExecutor(min(len(missing), os.cpu_count() or 1)) as pool:
            list(pool.map(_write, *zip(*missing, strict=True)))
    return _joined([_read(path, recipe, count) for path in paths])


def _write(recipe: SceneRecipe, seed: int, count: int, path: Path) -> None:
    rng = np.random.default_rng(seed)
    renderer = SceneRenderer(recipe)
    images = np.zeros((count, 64, 64, 3), np.uint8)
    labels = np.full((count, recipe.most_gates, 4), np.nan, np.float32)
    for index in range(count):
        images[index], seen = renderer.draw(rng)
        labels[index, : len(seen)] = seen
    renderer.close()
    unfinished = path.with_suffix(".part.npz")
    np.savez(unfinished, images=images, labels=labels, drawn_from=settings_sha256(asdict(recipe)))
    unfinished.replace(path)


def _read(path: Path, recipe: SceneRecipe, count: int) -> Scenes:
    advice = "choose another --data, or remove it"
    with np.load(path) as file:
        if str(file.get("drawn_from", "")) != settings_sha256(asdict(recipe)):
            raise UsageError(f"{path} holds scenes of another recipe: {advice}")
        scenes = Scenes(images=file["images"], labels=file["labels"])
    if len(scenes) != count:
        raise UsageError(f"{path} holds {len(scenes)} scenes, not {count}: {advice}")
    return scenes


def _joined(parts: list[Scenes]) -> Scenes:
    return Scenes(
        images=np.concatenate([part.images for part in parts]),
        labels=np.concatenate([part.labels for part in parts]),
    )
