import inspect

import numpy as np
import pytest
import torch

from flightstack.networks.images import image_bytes, network_input

RNG = np.random.default_rng(0)


def test_bytes_become_minus_one_to_one_and_back() -> None:
    rgb = RNG.integers(0, 256, (3, 64, 64, 3), dtype=np.uint8)
    rgb[0, 0, 0] = (0, 255, 128)
    images = network_input(rgb)
    assert images.shape == (3, 3, 64, 64)
    assert images[0, :, 0, 0].tolist() == pytest.approx([-1.0, 1.0, 1.0 / 255.0], abs=1e-6)
    assert (image_bytes(images) == rgb).all()


def test_input_needs_no_transposition() -> None:
    images = network_input(np.zeros((1, 64, 64, 3), dtype=np.uint8))
    assert images.is_contiguous(memory_format=torch.channels_last)


@pytest.mark.parametrize(
    "rgb",
    [
        np.zeros((64, 64, 3), dtype=np.uint8),
        np.zeros((1, 32, 64, 3), dtype=np.uint8),
        np.zeros((1, 64, 64, 3), dtype=np.float32),
    ],
)
def test_other_shapes_and_types_are_refused(rgb: np.ndarray) -> None:
    as_in_flight = inspect.unwrap(network_input)  # where nobody checks the signature
    with pytest.raises(ValueError, match=r"expected uint8 \(B, 64, 64, 3\)"):
        as_in_flight(rgb)
