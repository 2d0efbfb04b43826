from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.training.data import dataset, generation
from flightstack.training.data.flights import draw_radius_noise_m, fly, fly_until
from flightstack.training.data.piloting import Piloting
from flightstack.training.recipe import Recipe
from flightstack.training.seeds import TEST_TRACKS, TRAINING_TRACKS, VALIDATION_TRACKS

SHORT = replace(Recipe.load("strong").flights, frames=30)


@pytest.fixture(scope="module")
def flight() -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    return fly(np.random.default_rng(1), SHORT)


def test_a_flight_is_a_function_of_its_generator(
    flight: tuple[NDArray[np.uint8], NDArray[np.float32]],
) -> None:
    images, labels = fly(np.random.default_rng(1), SHORT)
    assert np.array_equal(images, flight[0])
    assert np.array_equal(labels, flight[1])


def test_fewer_frames_of_a_flight_are_those_of_the_whole(
    flight: tuple[NDArray[np.uint8], NDArray[np.float32]],
) -> None:
    images, labels = fly(np.random.default_rng(1), SHORT, every=7)
    assert np.array_equal(images, flight[0][::7])
    assert np.array_equal(labels, flight[1][::7])


def test_what_is_measured_on_comes_from_many_flights() -> None:
    images, labels = fly_until(np.random.default_rng(1), SHORT, tracks=VALIDATION_TRACKS, images=7)
    assert images.shape == (7, 64, 64, 3)
    assert labels.shape == (7, 4)
    first, commands = fly(np.random.default_rng(1), SHORT, tracks=VALIDATION_TRACKS, every=10)
    assert len(first) == 3  # of 30 frames: the other images are of other flights
    assert np.array_equal(images[:3], first)
    assert np.array_equal(labels[:3], commands)
    assert np.abs(images[3].astype(int) - images[0]).mean() > 1.0


def test_no_image_to_measure_on_is_a_clear_error() -> None:
    with pytest.raises(UsageError, match="--images must be 1 or more, got 0"):
        fly_until(np.random.default_rng(1), SHORT, tracks=VALIDATION_TRACKS, images=0)


def test_frames_move_and_commands_lead_ahead(
    flight: tuple[NDArray[np.uint8], NDArray[np.float32]],
) -> None:
    images, labels = flight
    assert images.shape == (len(labels), 64, 64, 3)
    assert len({image.tobytes() for image in images}) == len(images)
    assert np.isfinite(labels).all()
    assert labels[:, 0].mean() > 0.5
    assert np.abs(labels[:, 3]).max() <= 1.0


def test_a_pilot_flies_while_the_expert_labels(
    flight: tuple[NDArray[np.uint8], NDArray[np.float32]],
) -> None:
    asked = []

    def hover(image: NDArray[np.uint8]) -> NDArray[np.float64]:
        asked.append(image)
        return np.zeros(4)

    images, labels = fly(np.random.default_rng(1), SHORT, pilot=hover)
    assert np.array_equal(asked, images)
    assert labels[:, 0].mean() > 0.5  # the label stays the expert's, not the pilot's
    moved = np.abs(images[-1].astype(int) - images[0]).mean()
    flown = np.abs(flight[0][-1].astype(int) - flight[0][0]).mean()
    assert moved < flown


def test_training_validation_and_test_tracks_never_meet() -> None:
    ranges = sorted((r.start, r.stop) for r in (TEST_TRACKS, TRAINING_TRACKS, VALIDATION_TRACKS))
    assert all(stop <= start for (_, stop), (start, _) in pairwise(ranges))


def test_the_held_out_noise_level_is_never_drawn_and_all_others_are() -> None:
    rng, recipe = np.random.default_rng(4), Recipe.load("strong").flights
    low, high = recipe.held_out_radius_noise_m
    drawn = np.array([draw_radius_noise_m(rng, recipe) for _ in range(4000)])
    assert low < 1.0 < high
    assert not ((drawn >= low) & (drawn < high)).any()
    counts, _ = np.histogram(drawn, [0.0, low, high, recipe.most_radius_noise_m])
    expected = 4000 * np.array([low, 0.0, recipe.most_radius_noise_m - high]) / 1.3
    assert counts == pytest.approx(expected, abs=130)  # 4 standard deviations of a binomial


def test_a_recipe_that_holds_nothing_out_draws_as_before() -> None:
    recipe = Recipe.load("paper").flights
    drawn = draw_radius_noise_m(np.random.default_rng(7), recipe)
    assert drawn == np.random.default_rng(7).uniform(0.0, recipe.most_radius_noise_m)


def test_a_held_out_level_outside_the_range_is_refused() -> None:
    with pytest.raises(ValueError, match="held_out_radius_noise_m"):
        replace(SHORT, held_out_radius_noise_m=(1.4, 1.6))


def test_a_round_of_dagger_is_data_of_its_own(tmp_path: Path) -> None:
    recipe = replace(Recipe.load("strong"), flights=SHORT)
    piloting = Piloting.by("strong/m0", 1.0)
    sizes: dict[str, Any] = {"images": 20, "seed": 2, "jobs": 1, "report": lambda _: None}
    flown = generation.generate_control(tmp_path / "dagger", recipe, piloting=piloting, **sizes)
    generation.generate_control(tmp_path / "expert", recipe, **sizes)
    opened = dataset.read_dataset(flown)
    assert opened.manifest["pilot"]["model"] == "strong/m0"
    assert opened.sha256 != dataset.read_dataset(tmp_path / "expert").sha256
    with pytest.raises(UsageError, match="made with another model, share, weights_sha256"):
        generation.generate_control(tmp_path / "expert", recipe, piloting=piloting, **sizes)
