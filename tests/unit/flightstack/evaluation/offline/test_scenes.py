import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.evaluation.offline.scenes import DOUBLE_GATE, NO_GATE, PLAIN, SPOILS, render_scene

COUNT = 6
Scenes = dict[str, NDArray[np.float64]]


@pytest.fixture(scope="module")
def scenes() -> Scenes:
    return {kind: render_scene(kind, COUNT, seed=3).astype(float) for kind in SPOILS}


def test_scenes_are_a_function_of_their_seed(scenes: Scenes) -> None:
    assert np.array_equal(render_scene("fog", COUNT, seed=3), scenes["fog"])
    assert not np.array_equal(render_scene("fog", COUNT, seed=4), scenes["fog"])


def test_spoiled_scenes_show_what_the_plain_ones_do(scenes: Scenes) -> None:
    """Away from the gate the day is the same; the first row of the sky tells."""
    sky = scenes[PLAIN][:, 0]
    for kind in (NO_GATE, DOUBLE_GATE):
        assert np.abs(scenes[kind][:, 0] - sky).mean() < 3.0


def test_each_kind_is_spoiled_in_its_own_way(scenes: Scenes) -> None:
    plain = scenes[PLAIN]
    assert scenes["darkness"].mean() < 0.3 * plain.mean()
    contrast = {kind: np.abs(np.diff(images, axis=2)).mean() for kind, images in scenes.items()}
    assert contrast["fog"] < 0.4 * contrast[PLAIN]
    assert contrast["blur"] < 0.5 * contrast[PLAIN]
    assert contrast["unseen textures"] > 1.2 * contrast[PLAIN]


def test_two_gates_stand_on_either_side_and_none_where_there_is_none(scenes: Scenes) -> None:
    gates = np.abs(scenes[DOUBLE_GATE] - scenes[NO_GATE]).max(axis=3) > 20.0
    left, right = gates[:, :, :32].sum(axis=(1, 2)), gates[:, :, 32:].sum(axis=(1, 2))
    assert (left > 20).all()
    assert (right > 20).all()


def test_unknown_scene_names_the_known_ones() -> None:
    with pytest.raises(UsageError, match="unknown scene 'rain': choose one of plain, double gate"):
        render_scene("rain", 1, seed=0)
