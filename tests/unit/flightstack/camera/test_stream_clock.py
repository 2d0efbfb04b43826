"""A stream's stamps date its pictures, whatever the network took for each."""

import numpy as np
import pytest

from flightstack.camera.stream_clock import StreamClock

LEFT_S = 500.0  # our time of the first picture
BEGAN_S = -37.0  # what the stream calls it


def test_jitter_is_taken_off() -> None:
    rng = np.random.default_rng(0)
    clock = StreamClock()
    errors = []
    for number in range(400):
        true_s = number / 30
        received_s = LEFT_S + true_s + rng.uniform(0.0, 0.06)
        errors.append(clock.left_s(BEGAN_S + true_s, received_s) - LEFT_S - true_s)
    assert min(errors) >= 0.0
    assert max(errors[60:]) < 0.005


def test_nothing_leaves_after_it_was_received() -> None:
    clock = StreamClock()
    assert clock.left_s(1.0, 500.0) == 500.0
    assert clock.left_s(1.5, 500.1) == pytest.approx(500.1)  # quicker than the first
    assert clock.left_s(2.0, 500.9) == pytest.approx(500.6)


def test_another_quartz_is_followed() -> None:
    clock = StreamClock()
    for number in range(6000):
        true_s = number / 20
        left_s = clock.left_s(true_s * (1 + 100e-6), LEFT_S + true_s)
    assert left_s == pytest.approx(LEFT_S + true_s, abs=0.0015)


def test_a_clock_that_jumps_begins_anew() -> None:
    clock = StreamClock()
    clock.left_s(10.0, 500.0)
    assert clock.left_s(9.0, 500.05) == 500.05
    assert clock.left_s(9.05, 500.1) == pytest.approx(500.1)
