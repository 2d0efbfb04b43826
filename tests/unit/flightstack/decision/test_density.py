import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import gaussian_kde

from flightstack.decision.density import find_modes


def two_groups(low: float, high: float, share: float = 0.5) -> NDArray[np.float64]:
    """Samples (40, 4) around two values, `share` of them around the lower."""
    rng = np.random.default_rng(1)
    below = round(40 * share)
    centres = np.concatenate([np.full(below, low), np.full(40 - below, high)])
    return np.asarray(centres[:, np.newaxis] + rng.normal(0.0, 0.1, (40, 4)))


def test_one_group_is_one_mode_near_its_middle() -> None:
    modes = find_modes(two_groups(0.5, 0.5))
    assert (modes.count == 1).all()
    assert modes.lowest == pytest.approx(np.full(4, 0.5), abs=0.1)


def test_two_groups_are_two_modes() -> None:
    modes = find_modes(two_groups(-1.0, 2.0))
    assert (modes.count == 2).all()
    assert modes.lowest == pytest.approx(np.full(4, -1.0), abs=0.2)
    assert modes.highest == pytest.approx(np.full(4, 2.0), abs=0.2)
    assert modes.softest == pytest.approx(np.full(4, -1.0), abs=0.2)


def test_densest_is_where_most_samples_are() -> None:
    modes = find_modes(two_groups(-1.0, 2.0, share=0.3))
    assert modes.densest == pytest.approx(np.full(4, 2.0), abs=0.2)


def test_one_stray_sample_is_no_mode() -> None:
    values = np.concatenate([np.full((1, 4), -9.0), two_groups(0.5, 0.5)])
    assert find_modes(values).lowest == pytest.approx(np.full(4, 0.5), abs=0.6)


def test_density_has_the_shape_of_scipys() -> None:
    values = two_groups(-1.0, 2.0)
    modes = find_modes(values)
    reference = gaussian_kde(values[:, 0])
    # scipy divides by M - 1 where we divide by M: a bandwidth 1.3 % wider.
    expected = reference(modes.grid[0])
    found = modes.density[0] / modes.density[0].max()
    np.testing.assert_allclose(found, expected / expected.max(), atol=0.03)


@pytest.mark.parametrize("count", [1, 32])
def test_equal_samples_are_their_own_mode(count: int) -> None:
    values = np.tile([3.0, -2.0, 0.0, 1e-3], (count, 1))
    modes = find_modes(values)
    assert (modes.count == 1).all()
    assert modes.lowest == pytest.approx(values[0], abs=1e-8)
