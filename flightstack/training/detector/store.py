"""Scenes in files, each of its own seed: made once, read as often as they are trained on."""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import RgbStack
from flightstack.training.detector.scenes import SceneRecipe, SceneRenderer

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


def make_scenes(folder: Path, seeds: Sequence[int], count: int) -> Scenes:
    """Read the scenes of these seeds, so many of each; those that are missing are made first."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / f"{seed:06}.npz" for seed in seeds]
    missing = [(seed, count, path) for seed, path in zip(seeds, paths, strict=True)
               if not path.is_file()]  # fmt: skip
    if missing:
        with ProcessPoolExecutor(min(len(missing), os.cpu_count() or 1)) as pool:
            list(pool.map(_write, *zip(*missing, strict=True)))
    return _joined([_read(path) for path in paths])


def _write(seed: int, count: int, path: Path) -> None:
    recipe = SceneRecipe.load()
    rng = np.random.default_rng(seed)
    renderer = SceneRenderer(recipe)
    images = np.zeros((count, 64, 64, 3), np.uint8)
    labels = np.full((count, recipe.most_gates, 4), np.nan, np.float32)
    for index in range(count):
        images[index], seen = renderer.draw(rng)
        labels[index, : len(seen)] = seen
    renderer.close()
    unfinished = path.with_suffix(".part.npz")
    np.savez(unfinished, images=images, labels=labels)
    unfinished.replace(path)


def _read(path: Path) -> Scenes:
    with np.load(path) as file:
        return Scenes(images=file["images"], labels=file["labels"])


def _joined(parts: list[Scenes]) -> Scenes:
    return Scenes(
        images=np.concatenate([part.images for part in parts]),
        labels=np.concatenate([part.labels for part in parts]),
    )
