"""What models are judged on: flights over test tracks, gate views and scenes, none seen before."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.evaluation.offline.scenes import SPOILS, render_scene
from flightstack.training.data.flights import fly_until
from flightstack.training.data.gate_views import ViewRenderer
from flightstack.training.recipe import Recipe
from flightstack.training.seeds import TEST_TRACKS

FLIGHTS, VIEWS = 3, 4  # enter the seeds where training has its splits, 1 and 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Images and labels by one recipe's ranges."""

    flights: NDArray[np.uint8]  # (K, 64, 64, 3)
    commands: NDArray[np.float64]  # (K, 4) the expert's, m/s, rad/s
    views: NDArray[np.uint8]  # (V, 64, 64, 3)
    poses: NDArray[np.float64]  # (V, 4) m, rad
    scenes: dict[str, NDArray[np.uint8]]  # of each kind, (S, 64, 64, 3)


def make_material(recipe: Recipe, *, images: int, scenes: int, seed: int) -> Material:
    """Fly the recipe's expert over test tracks, and render views and scenes.

    Raises UsageError for less than an image.
    """
    rng = np.random.default_rng([seed, FLIGHTS])
    flown, commands = fly_until(rng, recipe.flights, tracks=TEST_TRACKS, images=images)
    rng = np.random.default_rng([seed, VIEWS])
    renderer = ViewRenderer(recipe.views)
    try:
        views = [renderer.draw(rng) for _ in range(images)]
    finally:
        renderer.close()
    return Material(
        flights=flown,
        commands=commands.astype(np.float64),
        views=np.stack([image for image, _ in views]),
        poses=np.stack([pose for _, pose in views]).astype(np.float64),
        scenes={
            kind: render_scene(kind, scenes, seed=seed, scenery=recipe.views.scenery)
            for kind in SPOILS
        },
    )
