import math
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest

from flightstack.errors import UsageError
from flightstack.training.data.generation import describe
from flightstack.training.hyperparameters import PerceptionTraining, Training
from flightstack.training.presets import images_of, perception_settings, policy_settings
from flightstack.training.recipe import RECIPE_FILE, Recipe
from tests.paths import DOCS

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
        ("[dagger]", "[training]\nimages = 5\n[dagger]", "training: unknown key 'images'"),
        (
            "[dagger]",
            "[training.policy]\nlearning_rate = 2\n[dagger]",
            "training.policy: learning_rate must be from 0 to 1, got 2",
        ),
        ("[dagger]", "[training.perception]\nbatch = 1\n[dagger]", "batch must be from 2"),
        ("[dagger]", "[scenery]\nlens = 1\n[dagger]", "scenery.lens: unknown key; known are gate"),
        (
            "[dagger]",
            "[scenery]\nfield_of_view_deg = 80\n[dagger]",
            "azimuth_deg, 43, must be below 40, half of the scenery's field of view",
        ),
        ("[dagger]", "[scenes]\ngates = 1\n[dagger]", "scenes: unknown key 'gates'"),
        ("[views]  #", "name = '../x'\n[views]  #", "recipe name '../x': a name of letters"),
        ("[views]  #", "base = 'weak'\n[views]  #", "recipe 'weak': unknown"),
        ("[views]  #", "base = 1\n[views]  #", "base: expected the name of a recipe, got 1"),
    ],
)
def test_a_wrong_line_is_named(old: str, new: str, match: str) -> None:
    assert old in STRONG_TEXT
    with pytest.raises(UsageError, match=match):
        Recipe.parse("mine", STRONG_TEXT.replace(old, new, 1))


def test_a_file_outside_says_only_what_is_different(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        "base = 'strong'\n[views]\nmost_distractors = 1\n"
        "[training]\ncontrol_images = 500\n[training.policy]\nhidden = [32, 16]\n"
        "[scenes]\npair_share = 0.0\n"
    )
    mine, strong = Recipe.load(str(path)), Recipe.load("strong")
    assert mine.name == "mine"
    assert mine.views == replace(strong.views, most_distractors=1)
    assert mine.flights == strong.flights
    assert mine.training.policy.hidden == (32, 16)
    assert mine.scenes == replace(strong.scenes, pair_share=0.0)
    assert images_of("full", "control", mine.training) == 500
    assert images_of("full", "perception", mine.training) == 300_000
    settings = policy_settings("quick", kind="single", seed=0, training=mine.training)
    assert (settings.hidden, settings.members) == ((32, 16), 1)


@pytest.mark.parametrize("name", ["strong", "paper"])
def test_a_recipe_is_read_as_it_was_written_under_whatever_name(name: str, tmp_path: Path) -> None:
    recipe = Recipe.load(name)
    (tmp_path / RECIPE_FILE).write_text(recipe.text())
    assert Recipe.beside(tmp_path, "cake") == recipe


def test_a_file_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"mine\.toml: can't be read"):
        Recipe.load(str(tmp_path / "mine.toml"))


def test_a_plain_encoder_has_no_dropout_whatever_a_recipe_says() -> None:
    training = Training(perception=PerceptionTraining(dropout=0.4, latent_dims=7))
    mcd, plain = (
        perception_settings("quick", encoder=encoder, seed=0, training=training)
        for encoder in ("mcd", "plain")
    )
    assert (mcd.dropout, plain.dropout) == (0.4, 0.0)
    assert mcd.latent_dims == plain.latent_dims == 7


def test_a_world_of_its_own_lies_under_views_flights_and_scenes(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        "base = 'strong'\n[scenery]\nfield_of_view_deg = 100\nground_pictures = ['lawn.png']\n"
        "[scenery.gate]\noutline = 'circle'\ninner_m = 0.8\nouter_m = 1.0\n"
    )
    recipe = Recipe.load(str(path))
    assert recipe.views.scenery == recipe.flights.scenery == recipe.scenes.scenery
    assert recipe.views.scenery.gate.outline == "circle"
    assert recipe.views.scenery.ground_pictures == (str(tmp_path / "lawn.png"),)
    copy = tmp_path / "elsewhere"
    copy.mkdir()
    (copy / RECIPE_FILE).write_text(recipe.text())
    assert Recipe.beside(copy, "cake") == recipe


def test_data_of_the_plain_world_are_what_they_were_before_there_were_others() -> None:
    for kind in ("perception", "control"):
        assert "scenery" not in describe(kind, Recipe.load("strong"), 0)["settings"]


def test_the_recipe_in_the_document_is_one(tmp_path: Path) -> None:
    section = (DOCS / "training-and-evaluation.md").read_text().partition("of your own\n")[2]
    path = tmp_path / "my.toml"
    path.write_text(section.split("```toml\n")[1].split("```")[0])
    recipe = Recipe.load(str(path))
    assert recipe.views.scenery.gate.outline == "circle"
    assert recipe.training.policy.hidden == (256, 128)
