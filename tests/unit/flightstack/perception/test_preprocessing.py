import numpy as np

from flightstack.perception.preprocessing import fit_image

RNG = np.random.default_rng(0)


def test_image_of_the_right_size_is_untouched() -> None:
    rgb = RNG.integers(0, 256, (64, 64, 3), dtype=np.uint8)
    assert fit_image(rgb) is rgb


def test_wide_image_gives_its_middle_square() -> None:
    rgb = np.zeros((128, 256, 3), dtype=np.uint8)
    rgb[:, 64:192] = (10, 200, 30)
    assert (fit_image(rgb) == (10, 200, 30)).all()
