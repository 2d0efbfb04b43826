from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from flightstack.training.flights import fly
from flightstack.training.recipe import Recipe
from flightstack.training.seeds import TEST_TRACKS, TRAINING_TRACKS, VALIDATION_TRACKS

SHORT = replace(Recipe.load("strong").flights, frames=30)


@pytest.fixture(scope="module")
def flight():
    return fly(np.random.default_rng(1), SHORT)


def test_a_flight_is_a_function_of_its_generator(flight):
    images, labels = fly(np.random.default_rng(1), SHORT)
    assert np.array_equal(images, flight[0])
    assert np.array_equal(labels, flight[1])


def test_frames_move_and_commands_lead_ahead(flight):
    images, labels = flight
    assert images.shape == (len(labels), 64, 64, 3)
    assert len({image.tobytes() for image in images}) == len(images)
    assert np.isfinite(labels).all()
    assert labels[:, 0].mean() > 0.5
    assert np.abs(labels[:, 3]).max() <= 1.0


def test_a_pilot_flies_while_the_expert_labels(flight):
    asked = []

    def hover(image):
        asked.append(image)
        return np.zeros(4)

    images, labels = fly(np.random.default_rng(1), SHORT, pilot=hover)
    assert np.array_equal(asked, images)
    assert labels[:, 0].mean() > 0.5  # the label stays the expert's, not the pilot's
    moved = np.abs(images[-1].astype(int) - images[0]).mean()
    flown = np.abs(flight[0][-1].astype(int) - flight[0][0]).mean()
    assert moved < flown


def test_training_validation_and_test_tracks_never_meet():
    ranges = sorted((r.start, r.stop) for r in (TEST_TRACKS, TRAINING_TRACKS, VALIDATION_TRACKS))
    assert all(stop <= start for (_, stop), (start, _) in pairwise(ranges))
