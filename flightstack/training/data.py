"""Make the datasets, shard by shard, on all cores.

Shard k of a split depends on (seed, split, k) alone, so the same seed gives the same bytes on
any number of cores, and an interrupted run goes on where it stopped.
"""

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from flightstack.training import dataset
from flightstack.training.gate_views import LABEL_NAMES, ViewRecipe, ViewRenderer

SPLITS = {"train": 1, "validation": 2}  # the numbers enter the seeds
VIEWS_PER_SHARD = 2500
PERCEPTION_TRAIN_SHARE = 0.8

MakeShard = Callable[[Path, str, str, int, int, int], int]


def generate_perception(
    folder: Path, *, images: int, seed: int, jobs: int = -1, report: Callable[[str], None] = print
) -> Path:
    """Render `images` labelled gate views into `folder` (80 % train, 20 % validation)."""
    plan = _plan(images, VIEWS_PER_SHARD, PERCEPTION_TRAIN_SHARE)
    about = {"kind": "perception", "seed": seed, "recipe": asdict(ViewRecipe())}
    _generate(folder, plan, seed, _make_views, jobs=jobs, report=report)
    names = [name for name, *_ in plan]
    dataset.write_manifest(folder, names, label_names=LABEL_NAMES, about=about)
    return folder


def _plan(count: int, per_shard: int, train_share: float) -> list[tuple[str, str, int, int]]:
    """Shards as (name, split, index within the split, count)."""
    train = round(count * train_share)
    plan = []
    for split, total in (("train", train), ("validation", count - train)):
        for index, start in enumerate(range(0, total, per_shard)):
            size = min(per_shard, total - start)
            plan.append((f"{split}-{index:05d}", split, index, size))
    return plan


def _generate(
    folder: Path,
    plan: list[tuple[str, str, int, int]],
    seed: int,
    make: MakeShard,
    *,
    jobs: int,
    report: Callable[[str], None],
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    missing = [shard for shard in plan if not dataset.is_finished(folder, shard[0])]
    images_left = sum(shard[3] for shard in missing)
    started = time.monotonic()
    done = 0
    results = Parallel(n_jobs=jobs, return_as="generator_unordered")(
        delayed(make)(folder, name, split, index, count, seed)
        for name, split, index, count in missing
    )
    for count in results:
        done += count
        rate = done / (time.monotonic() - started)
        report(f"{folder.name}: {done} of {images_left} images, {rate:.0f} a second")


def _make_views(folder: Path, name: str, split: str, index: int, count: int, seed: int) -> int:
    rng = np.random.default_rng([seed, SPLITS[split], index])
    renderer = ViewRenderer(ViewRecipe())
    images = np.empty((count, 64, 64, 3), dtype=np.uint8)
    labels: NDArray[np.float32] = np.empty((count, len(LABEL_NAMES)), dtype=np.float32)
    for i in range(count):
        images[i], labels[i] = renderer.draw(rng)
    renderer.close()
    dataset.write_shard(folder, name, split, images, labels)
    return count
