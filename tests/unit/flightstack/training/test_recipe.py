import math
from importlib.resources import files

import pytest

from flightstack.errors import UsageError
from flightstack.training.recipe import Recipe

STRONG_TEXT = (files("flightstack.training") / "recipes" / "strong.toml").read_text()


def test_the_paper_shows_one_gate_and_never_disturbs_its_expert() -> None:
    recipe = Recipe.load("paper")
    assert recipe.views.most_distractors == 0
    assert recipe.flights.noise_std == (0.0, 0.0, 0.0, 0.0)
    assert recipe.flights.expert == "minimum-jerk"


def test_degrees_become_radians() -> None:
    assert Recipe.load("strong").views.tilt_rad == pytest.approx(math.radians(18.0))


def test_an_unknown_recipe_names_the_known() -> None:
    with pytest.raises(UsageError, match="paper, strong"):
        Recipe.load("weak")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        ("tilt_deg = 18.0", "tilt_deg = 18.0\nspeed = 3", "mine.views: unknown key 'speed'"),
        ("tilt_deg = 18.0", "", "'tilt_rad' is missing"),
        ("height_m = [0.5, 8.0]", "height_m = [0.5]", "expected 2 numbers"),
        ("most_distractors = 3", "most_distractors = 2.5", "expected int"),
        ("noise_share = 0.5", "noise_share = nan", "expected float"),
        (
            'expert = "funnel"',
            'expert = "lucky"',
            "one of 'funnel', 'minimum-jerk', got",
        ),
        ("[flights]", "[planes]", "unknown key 'planes'; known are views, flights, dagger"),
        ("share = 0.25\nvis", "share = 1.25\nvis", "fog: share must be from 0 to 1, got 1.25"),
        ("visibility_m = [12.0", "visibility_m = [90.0", r"fog: visibility_m \[90.* not in order"),
        ("images_share = 0.5", "", "dagger: 'images_share' is missing"),
        (
            "images_share = 0.5",
            "images_share = 0.0",
            "images_share must be above 0, up to 10, got 0.0",
        ),
        ("[views]  #", "[views]\nfog = 1  #", "expected a table, got 1"),
        ("range_m = [", "range_m = [[", "not TOML"),
    ],
)
def test_a_wrong_line_is_named(old: str, new: str, match: str) -> None:
    assert old in STRONG_TEXT
    with pytest.raises(UsageError, match=match):
        Recipe.parse("mine", STRONG_TEXT.replace(old, new, 1))
