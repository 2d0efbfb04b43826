"""The recipe for a poor estimate: rotor noise in the flights, and an expert that stands it."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from flightstack.errors import UsageError
from flightstack.training.data import describe
from flightstack.training.expert import ExpertConfig
from flightstack.training.flights import fly
from flightstack.training.recipe import FUNNEL, Recipe

STEADY, STRONG = Recipe.load("steady"), Recipe.load("strong")
FRAMES = 120


def test_rotor_noise_is_drawn_up_to_its_most_and_without_any_nothing_is():
    rng = np.random.default_rng(3)
    assert STRONG.flights.draw_rotor_noise_share(rng) == 0.0
    assert rng.random() == np.random.default_rng(3).random()
    drawn = np.array([STEADY.flights.draw_rotor_noise_share(rng) for _ in range(2000)])
    assert 0.0 <= drawn.min() < 0.01
    assert 0.99 < drawn.max() <= 1.0
    assert drawn.mean() == pytest.approx(0.5, abs=0.03)


def test_a_recipe_that_says_nothing_has_the_experts_own_figures():
    config = ExpertConfig()
    assert (config.speed_m_s, config.look_ahead_m, config.look_ahead_share) == FUNNEL
    assert "speed_m_s" not in describe("control", STRONG, 0)["settings"]  # its data stays known
    assert describe("control", STEADY, 0)["settings"]["most_rotor_noise_share"] == 1.0


def test_steady_differs_from_strong_in_its_flights_alone():
    assert STEADY.views == STRONG.views
    changed = {
        name
        for name, value in asdict(STEADY.flights).items()
        if value != asdict(STRONG.flights)[name]
    }
    assert changed == {
        "speed_m_s",
        "look_ahead_m",
        "look_ahead_share",
        "most_rotor_noise_share",
    }


def test_flights_are_flown_with_rotor_noise_and_by_the_recipes_expert():
    calm = replace(
        STEADY.flights,
        frames=FRAMES,
        calm_share=1.0,
        start_at_spawn_share=1.0,
        fog=STRONG.flights.fog,
    )
    still, shaken, brisk = (
        fly(np.random.default_rng(5), recipe)[1]
        for recipe in (
            replace(calm, most_rotor_noise_share=0.0),
            calm,
            replace(calm, most_rotor_noise_share=0.0, speed_m_s=2.0),
        )
    )
    assert still[:, 0].max() < 1.75 < brisk[:, 0].max()
    assert np.abs(shaken[:, 1] - still[:, 1]).max() > 0.1  # corrections of what it drifts


@pytest.mark.parametrize(
    "change",
    [
        {"most_rotor_noise_share": 1.5},
        {"speed_m_s": 0.0},
        {"look_ahead_m": -1.0},
        {"look_ahead_share": 2.0},
        {"expert": "minimum-jerk"},
    ],
)
def test_figures_that_cannot_be_are_refused(change):
    with pytest.raises(UsageError, match=r"^flights"):
        replace(STEADY.flights, **change)
