"""Fog in the training data: drawn where a recipe asks for it, and nothing else changes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flightstack.evaluation.trials.rungs import load_rung
from flightstack.training.data.flights import fly
from flightstack.training.data.gate_views import ViewRenderer
from flightstack.training.data.generation import describe
from flightstack.training.recipe import NO_FOG, Fog, Recipe

THICK = Fog(share=1.0, visibility_m=(6.0, 6.0))
VIEWS = replace(Recipe.load("strong").views, range_m=(5.0, 6.0), blur_share=0.0, noise_share=0.0)
SHORT = replace(Recipe.load("strong").flights, frames=10)


def contrast(images: np.ndarray) -> float:
    return float(np.std(images, axis=(-3, -2)).mean())


def test_without_fog_nothing_is_drawn() -> None:
    rng = np.random.default_rng(3)
    assert NO_FOG.draw_visibility_m(rng) == math.inf
    assert rng.random() == np.random.default_rng(3).random()


def test_fog_comes_as_often_and_as_thick_as_the_recipe_says() -> None:
    rng, fog = np.random.default_rng(3), Fog(share=0.3, visibility_m=(10.0, 40.0))
    drawn = np.array([fog.draw_visibility_m(rng) for _ in range(4000)])
    foggy = drawn[np.isfinite(drawn)]
    assert len(foggy) == pytest.approx(1200, abs=120)  # 4 standard deviations of a binomial
    assert (foggy >= 10.0).all()
    assert (foggy <= 40.0).all()
    assert np.mean(foggy < 20.0) == pytest.approx(0.5, abs=0.06)  # log-uniform


def test_views_lose_their_contrast_but_keep_their_gates() -> None:
    images, labels = [], []
    for fog in (THICK, NO_FOG):
        renderer = ViewRenderer(replace(VIEWS, fog=fog))
        image, label = renderer.draw(np.random.default_rng(5))
        renderer.close()
        images.append(image)
        labels.append(label)
    assert contrast(images[0]) < 0.5 * contrast(images[1])
    assert np.array_equal(labels[0], labels[1])


def test_flights_are_flown_in_fog() -> None:
    foggy, clear = (
        np.concatenate([fly(np.random.default_rng(k), replace(SHORT, fog=fog))[0] for k in (1, 2)])
        for fog in (THICK, NO_FOG)
    )
    assert contrast(foggy) < 0.6 * contrast(clear)


def test_strong_has_fog_thinner_than_the_ladders_and_paper_has_none() -> None:
    strong, paper = Recipe.load("strong"), Recipe.load("paper")
    assert strong.views.fog == strong.flights.fog
    assert strong.views.fog.share > 0.0
    (option,) = load_rung("fog")[1].vehicle_options
    assert float(option.removeprefix("--condition=light.fog_visibility_m=")) < 12.0
    assert strong.views.fog.visibility_m[0] >= 12.0
    assert paper.views.fog == paper.flights.fog == NO_FOG


def test_fog_is_among_what_data_depend_on() -> None:
    assert describe("perception", Recipe.load("paper"), 0)["settings"]["fog"]["share"] == 0.0
    assert describe("control", Recipe.load("strong"), 0)["settings"]["fog"]["share"] == 0.25
