import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightstack.perception.labels import MIRRORED, LabelScale


def make_labels(seed: int = 0, count: int = 500) -> np.ndarray:
    rng = np.random.default_rng(seed)
    low, high = (0.3, -0.7, -0.5, -1.5), (14.0, 0.7, 0.9, 1.5)
    return rng.uniform(low, high, (count, 4)).astype(np.float32)


@given(seed=st.integers(0, 1000))
def test_labels_survive_the_scale_and_back(seed: int) -> None:
    labels = make_labels(seed)
    scale = LabelScale.of(labels)
    np.testing.assert_allclose(scale.decode(scale.encode(labels)), labels, rtol=1e-4, atol=1e-5)


def test_scaled_labels_have_unit_mean_square() -> None:
    labels = make_labels()
    scaled = LabelScale.of(labels).encode(labels)
    np.testing.assert_allclose(np.square(scaled).mean(axis=0), np.ones(4), rtol=1e-4)


def test_mirrored_label_is_the_negated_scaled_one() -> None:
    labels = make_labels()
    scale = LabelScale.of(labels)
    mirrored = scale.encode(labels * MIRRORED.astype(np.float32))
    np.testing.assert_allclose(mirrored, scale.encode(labels) * MIRRORED, atol=1e-6)


def test_scale_that_is_not_positive_is_refused() -> None:
    with pytest.raises(ValueError, match="must be positive"):
        LabelScale(offset=(0.0,) * 4, scale=(1.0, 1.0, 0.0, 1.0))
