"""The filter lets slow turns through, starts at rest, and takes most of the rotors' shake away."""

import math

import numpy as np
import pytest

from sitl.sensors.estimate.gyro_filter import CUTOFF_HZ, GyroFilter


def passed_share(frequency_hz: float) -> float:
    """Amplitude of a sine that leaves the filter."""
    smooth = GyroFilter()
    times = np.arange(2500) * 0.004
    given = np.sin(2.0 * math.pi * frequency_hz * times)
    taken = np.array([smooth.update((value, 0.0, 0.0))[0] for value in given.tolist()])
    return float(np.abs(taken[1250:]).max())


def test_starts_with_the_first_sample() -> None:
    smooth = GyroFilter()
    for _ in range(5):
        assert smooth.update((0.3, -0.2, 0.1)) == pytest.approx((0.3, -0.2, 0.1))
    smooth.restart()
    assert smooth.update((1.0, 2.0, 3.0)) == pytest.approx((1.0, 2.0, 3.0))


@pytest.mark.parametrize(
    ("frequency_hz", "share"), [(1.0, 1.0), (CUTOFF_HZ, math.sqrt(0.5)), (110.0, 0.01)]
)
def test_is_a_low_pass(frequency_hz: float, share: float) -> None:
    assert passed_share(frequency_hz) == pytest.approx(share, abs=0.02)


def test_axes_do_not_mix() -> None:
    smooth, alone = GyroFilter(), GyroFilter()
    for tick in range(100):
        value = math.sin(tick)
        mixed = smooth.update((value, 5.0, -value))
        assert mixed[0] == alone.update((value, 0.0, 0.0))[0]
        assert mixed[1] == pytest.approx(5.0)
        assert mixed[2] == -mixed[0]
