"""Make the datasets, shard by shard, on all cores: gate views, and flights that the expert labels.

Shard k of a split depends on (seed, split, k) alone, so the same seed gives the same bytes on
any number of cores, and an interrupted run goes on where it stopped.
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from flightstack.arrays import Labels, RgbStack
from flightstack.perception.labels import LABELS
from flightstack.records import VELOCITIES
from flightstack.training.data.flights import fly
from flightstack.training.data.gate_views import ViewRenderer
from flightstack.training.data.manifest import refuse_other, settings_sha256, write_manifest
from flightstack.training.data.piloting import Piloting
from flightstack.training.data.shards import is_finished, write_shard
from flightstack.training.progress import duration_text
from flightstack.training.recipe import PLAIN, Recipe
from flightstack.training.seeds import TRAINING_TRACKS, VALIDATION_TRACKS

SPLITS = {"train": 1, "validation": 2}  # the numbers enter the seeds
TRACKS = {"train": TRAINING_TRACKS, "validation": VALIDATION_TRACKS}
VIEWS_PER_SHARD = 2500
FLIGHT_IMAGES_PER_SHARD = 1000
PERCEPTION_TRAIN_SHARE = 0.8  # paper
CONTROL_TRAIN_SHARE = 0.9  # paper

Report = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class ShardPlan:
    """One shard to be made; `index` counts within its split, and enters its seed."""

    split: str
    index: int
    count: int

    @property
    def name(self) -> str:
        """Stem of its files."""
        return f"{self.split}-{self.index:05d}"


Make = Callable[[ShardPlan], tuple[RgbStack, Labels]]


def describe(
    kind: str, recipe: Recipe, seed: int, piloting: Piloting | None = None
) -> dict[str, Any]:
    """Name all that a dataset's bytes depend on, but its size."""
    part = recipe.views if kind == "perception" else recipe.flights
    settings = asdict(part)
    if part.scenery == PLAIN:  # as before there was any other
        del settings["scenery"]
    about = {"kind": kind, "recipe": recipe.name, "seed": seed, "settings": settings}
    return about if piloting is None else {**about, "pilot": piloting.describe()}


def generate_perception(
    folder: Path,
    recipe: Recipe,
    *,
    images: int,
    seed: int,
    jobs: int = -1,
    report: Report = print,
) -> Path:
    """Render `images` labelled gate views into `folder` (80 % train, 20 % validation).

    Raises UsageError where the folder holds other data.
    """
    plans = _plan(images, VIEWS_PER_SHARD, PERCEPTION_TRAIN_SHARE)
    about = describe("perception", recipe, seed)
    _generate(folder, plans, about, partial(_make_views, recipe=recipe, seed=seed), jobs, report)
    names = [plan.name for plan in plans]
    write_manifest(folder, names, label_names=LABELS, about=about)
    return folder


def generate_control(
    folder: Path,
    recipe: Recipe,
    *,
    images: int,
    seed: int,
    piloting: Piloting | None = None,
    jobs: int = -1,
    report: Report = print,
) -> Path:
    """Fly the expert and label `images` images on the way (90 % train, 10 % validation).

    Raises UsageError where the folder holds other data.
    """
    plans = _plan(images, FLIGHT_IMAGES_PER_SHARD, CONTROL_TRAIN_SHARE)
    about = describe("control", recipe, seed, piloting)
    make = partial(_make_flights, recipe=recipe, seed=seed, piloting=piloting)
    _generate(folder, plans, about, make, jobs, report)
    names = [plan.name for plan in plans]
    write_manifest(folder, names, label_names=VELOCITIES, about=about)
    return folder


def _plan(count: int, per_shard: int, train_share: float) -> list[ShardPlan]:
    train = round(count * train_share)
    return [
        ShardPlan(split=split, index=index, count=min(per_shard, total - start))
        for split, total in (("train", train), ("validation", count - train))
        for index, start in enumerate(range(0, total, per_shard))
    ]


def _generate(
    folder: Path,
    plans: list[ShardPlan],
    about: dict[str, Any],
    make: Make,
    jobs: int,
    report: Report,
) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    refuse_other(folder, about, {plan.name: plan.count for plan in plans})
    missing = [plan for plan in plans if not is_finished(folder, plan.name)]
    total = sum(plan.count for plan in missing)
    started = time.monotonic()
    done = 0
    settings = settings_sha256(about)
    counts = Parallel(n_jobs=jobs, return_as="generator_unordered")(
        delayed(_make_shard)(folder, plan, make, settings) for plan in missing
    )
    for count in counts:
        done += count
        rate = done / (time.monotonic() - started)
        left = duration_text((total - done) / rate)
        report(f"{folder.name}: {done} of {total} images, {rate:.0f} a second, {left} left")


def _make_shard(folder: Path, plan: ShardPlan, make: Make, settings_sha256: str) -> int:
    images, labels = make(plan)
    write_shard(folder, plan.name, plan.split, images, labels, settings_sha256=settings_sha256)
    return plan.count


def _make_views(plan: ShardPlan, recipe: Recipe, seed: int) -> tuple[RgbStack, Labels]:
    rng = np.random.default_rng([seed, SPLITS[plan.split], plan.index])
    renderer = ViewRenderer(recipe.views)
    try:
        views = [renderer.draw(rng) for _ in range(plan.count)]
    finally:
        renderer.close()
    return np.stack([image for image, _ in views]), np.stack([label for _, label in views])


def _make_flights(
    plan: ShardPlan, recipe: Recipe, seed: int, piloting: Piloting | None
) -> tuple[RgbStack, Labels]:
    rng = np.random.default_rng([seed, SPLITS[plan.split], plan.index])
    model = None if piloting is None else piloting.load(seed=int(rng.integers(2**31)))
    images, labels, count = [], [], 0
    while count < plan.count:
        pilot = model if piloting and rng.random() < piloting.share else None
        flown, commands = fly(rng, recipe.flights, tracks=TRACKS[plan.split], pilot=pilot)
        images.append(flown)
        labels.append(commands)
        count += len(flown)
    return np.concatenate(images)[: plan.count], np.concatenate(labels)[: plan.count]
