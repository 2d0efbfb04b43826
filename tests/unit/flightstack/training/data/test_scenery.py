"""Views and flights in a world of one's own: its gates are seen, and flown through."""

from contextlib import closing
from dataclasses import replace

import numpy as np

from flightstack.training.data.flights import fly
from flightstack.training.data.gate_views import ViewRenderer
from flightstack.training.recipe import Recipe
from sitl import GateShape, Scenery

BLUE = (0.0, 0.1, 0.9)
STRONG = Recipe.load("strong")
SMALL_AND_BLUE = Scenery(
    gate=GateShape(outline="circle", inner_m=0.9, outer_m=1.3),
    gate_colour_low=BLUE,
    gate_colour_high=BLUE,
    field_of_view_deg=100.0,
)


def blueness(rgb: np.ndarray) -> float:
    """How far the bluest pixels stand out: a gate of red and yellow has none below the horizon."""
    wide = rgb.astype(int)
    return float(np.quantile(wide[..., 2] - wide[..., 0], 0.995))


def test_views_show_the_gates_of_the_recipe() -> None:
    ranges = replace(STRONG.views, range_m=(2.0, 3.0), most_distractors=0, scenery=SMALL_AND_BLUE)
    with closing(ViewRenderer(ranges)) as renderer:
        views = [renderer.draw(np.random.default_rng(k)) for k in range(6)]
    assert all(blueness(image) > 60 for image, _ in views)


def test_the_expert_flies_through_gates_of_another_shape_and_sees_them() -> None:
    recipe = replace(STRONG.flights, frames=60, calm_share=1.0, start_at_spawn_share=0.0)
    images, commands = fly(np.random.default_rng(1), replace(recipe, scenery=SMALL_AND_BLUE))
    assert len(images) == len(commands) == 60  # three seconds and no collision
    assert np.mean([blueness(image) > 60 for image in images]) > 0.5
