"""A clock is found behind a link that jitters, followed when it jumps, and never overrated."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightstack.mavlink.clock.clock_offset import MIN_TRIPS, ClockOffset

PERIOD_S = 0.1
OFFSET_S = -812.25
Delays = st.lists(
    st.tuples(st.floats(0.0, 0.3), st.floats(0.0, 0.3)), min_size=MIN_TRIPS, max_size=60
)


class Run:
    """Round trips, one every 0.1 s, and what the other clock shows meanwhile."""

    def __init__(self, seed: int = 0, *, offset_s: float = OFFSET_S, rate: float = 1.0) -> None:
        self.estimate = ClockOffset()
        self.rng = np.random.default_rng(seed)
        self.now_s = 1000.0
        self.offset_s = offset_s
        self.rate = rate

    def true_s(self, at_s: float) -> float:
        return self.offset_s + 1000.0 + (at_s - 1000.0) * self.rate

    def trip(self, there_s: float, back_s: float) -> None:
        sent_s = self.now_s
        self.estimate.add(sent_s, self.true_s(sent_s + there_s), sent_s + there_s + back_s)
        self.now_s += PERIOD_S

    def jitter(self, seconds: float, low_s: float = 0.01, high_s: float = 0.07) -> None:
        for _ in range(round(seconds / PERIOD_S)):
            self.trip(*self.rng.uniform(low_s, high_s, 2))

    def error_s(self) -> float:
        line = self.estimate.line()
        assert line is not None
        return line.at_us(self.now_s) / 1e6 - self.true_s(self.now_s)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("skew_ppm", [-50.0, 50.0])
def test_jitter_of_30_ms_each_way_leaves_less_than_5_ms(seed: int, skew_ppm: float) -> None:
    run = Run(seed, rate=1.0 + skew_ppm * 1e-6)
    run.jitter(10.0)
    assert abs(run.error_s()) < 0.005


@pytest.mark.parametrize("skew_ppm", [-50.0, 50.0])
def test_after_two_minutes_the_skew_is_known(skew_ppm: float) -> None:
    run = Run(rate=1.0 + skew_ppm * 1e-6)
    run.jitter(120.0)
    assert abs(run.error_s()) < 0.005
    quality = run.estimate.quality()
    assert quality is not None
    assert quality.skew_ppm is not None
    assert quality.skew_ppm == pytest.approx(skew_ppm, abs=60.0)
    assert quality.round_trip_s == pytest.approx(0.08, abs=0.015)


def test_a_quick_link_leaves_next_to_nothing() -> None:
    run = Run(rate=1.0 + 40e-6)
    run.jitter(120.0, 0.0005, 0.0015)
    quality = run.estimate.quality()
    assert quality is not None
    assert abs(run.error_s()) < 0.0005
    assert quality.skew_ppm == pytest.approx(40.0, abs=5.0)
    assert quality.uncertainty_s < 0.001


@given(delays=Delays)
@settings(max_examples=60, deadline=None)
def test_the_truth_is_never_outside_of_what_is_left_open(
    delays: list[tuple[float, float]],
) -> None:
    run = Run()
    for there_s, back_s in delays:
        run.trip(there_s, back_s)
    quality = run.estimate.quality()
    assert quality is not None
    assert abs(quality.offset_s - OFFSET_S) <= quality.uncertainty_s + 1e-6


def test_a_jump_is_followed_at_once() -> None:
    run = Run()
    run.jitter(10.0)
    run.offset_s += 3.0
    run.trip(0.04, 0.04)
    assert run.estimate.line() is None
    run.jitter(10.0)
    assert abs(run.error_s()) < 0.005


@pytest.mark.parametrize("rate", [0.0, 0.5, 2.0, 20.0])
def test_a_clock_at_another_speed_has_no_offset(rate: float) -> None:
    run = Run(rate=rate)
    run.jitter(10.0, 0.0005, 0.0015)
    assert run.estimate.line() is None
    assert run.estimate.quality() is None


def test_answers_that_took_too_long_or_no_time_say_nothing() -> None:
    estimate = ClockOffset()
    for number in range(10):
        estimate.add(number, number + 5.0, number + 1.5)
        estimate.add(number, number + 5.0, number - 0.1)
    assert estimate.line() is None
