"""Whatever the lens, the network sees its pinhole."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from flightstack.arrays import Rgb
from flightstack.camera.lens.camera_info import CameraInfo
from flightstack.camera.lens.network_view import ImageSizeError, NetworkView
from tests.lenses import FISHEYE, RATIONAL, STRONG, Lens


def scene(side_px: int) -> Rgb:
    """A smooth picture without symmetry, the same at any size."""
    steps = (np.arange(side_px) + 0.5) / side_px
    x, y = np.meshgrid(steps, steps)
    red, green = np.sin(9 * x + 2 * y), np.sin(7 * y - 3 * x * x)
    rgb = np.stack([red, green, x * y], axis=2)
    return np.asarray(127.5 * (1 + rgb), np.uint8)


def shrunk(rgb: Rgb) -> Rgb:
    return np.asarray(cv2.resize(rgb, (64, 64), interpolation=cv2.INTER_AREA), np.uint8)


@pytest.mark.parametrize("info", [STRONG, RATIONAL, FISHEYE], ids=lambda info: info.model)
def test_a_lens_is_undone(info: CameraInfo) -> None:
    view = NetworkView(info)
    seen, true = shrunk(view.of(Lens(info, 512)(scene(512)))), scene(64)
    error = np.abs(seen.astype(int) - true)
    assert view.covered_share > 0.99
    assert error[2:-2, 2:-2].mean() < 1.5  # levels of 255
    assert error[2:-2, 2:-2].max() < 12


def test_left_as_it_comes_the_same_lens_shows_something_else() -> None:
    seen = cv2.resize(Lens(STRONG, 512)(scene(512))[:, 20:140], (64, 64))
    assert np.abs(seen.astype(int) - scene(64)).mean() > 15


def test_images_of_the_same_camera_at_half_the_size_are_seen_alike() -> None:
    whole = Lens(RATIONAL, 512)(scene(512))
    half = np.asarray(cv2.resize(whole, (320, 240), interpolation=cv2.INTER_AREA), np.uint8)
    view = NetworkView(RATIONAL)
    large, small = shrunk(view.of(whole)), shrunk(view.of(half))
    assert np.abs(large.astype(int) - small).mean() < 1.5


def test_images_of_another_shape_are_refused_with_both_sizes() -> None:
    with pytest.raises(
        ImageSizeError, match="640 x 360 pixels, but --camera-info is for 640 x 480"
    ):
        NetworkView(RATIONAL).of(np.zeros((360, 640, 3), np.uint8))


def test_a_narrow_lens_leaves_the_rest_black() -> None:
    narrow = replace(RATIONAL, model="plumb_bob", coefficients=np.zeros(5))
    narrow = replace(narrow, matrix=np.array([[480.0, 0, 319.5], [0, 480.0, 239.5], [0, 0, 1]]))
    view = NetworkView(narrow)
    seen = view.of(np.full((480, 640, 3), 200, np.uint8))
    assert view.covered_share == pytest.approx(2 / 3 * 1 / 2, abs=0.02)  # of tan 33.7, tan 26.6
    assert (seen == 200).all(axis=2).mean() == pytest.approx(view.covered_share, abs=0.02)
    assert (seen[0] == 0).all()


def test_where_the_polynomial_folds_back_nothing_is_seen_twice() -> None:
    folding = replace(STRONG, coefficients=np.array([-0.3, 0.0, 0.0, 0.0, 0.0]))  # from r = 1.05 on
    view = NetworkView(folding)
    seen = view.of(np.full((120, 160, 3), 200, np.uint8))
    corners = [seen[row, column].tolist() for row in (0, -1) for column in (0, -1)]
    assert corners == [[0, 0, 0]] * 4
    assert seen[seen.shape[0] // 2, 2].tolist() == [200, 200, 200]


def test_a_perfect_pinhole_passes_untouched() -> None:
    pinhole = replace(
        STRONG,
        width_px=64,
        height_px=64,
        matrix=np.array([[32.0, 0, 31.5], [0, 32.0, 31.5], [0, 0, 1]]),
        coefficients=np.zeros(5),
    )
    assert np.array_equal(NetworkView(pinhole).of(scene(64)), scene(64))
