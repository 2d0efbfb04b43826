import logging

import pytest

from sitl.process.pacing import Pace


class Clock:
    """A wall clock that is set by hand."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


@pytest.mark.parametrize(("factor", "wait_s"), [(1.0, 2.0), (4.0, 0.5), (0.5, 4.0), (0.0, 0.0)])
def test_vehicle_time_is_scaled(factor: float, wait_s: float) -> None:
    pace = Pace(factor, Clock())
    assert pace.wait_s(2_000_000) == pytest.approx(wait_s)


def test_a_small_delay_is_caught_up() -> None:
    clock = Clock()
    pace = Pace(1.0, clock)
    clock.now_s += 0.4
    assert pace.wait_s(100_000) == 0.0
    assert pace.wait_s(500_000) == pytest.approx(0.1)


def test_a_large_delay_is_given_up_and_told_of_once(caplog: pytest.LogCaptureFixture) -> None:
    clock = Clock()
    pace = Pace(1.0, clock)
    with caplog.at_level(logging.WARNING):
        for _ in range(2):
            clock.now_s += 3.0
            assert pace.wait_s(1_000_000) == 0.0
            assert pace.wait_s(1_100_000) == pytest.approx(0.1)
    assert len(caplog.records) == 1
    assert "2.0 s behind" in caplog.text


def test_a_restart_lets_now_be_the_given_time() -> None:
    clock = Clock()
    pace = Pace(1.0, clock)
    clock.now_s += 50.0
    pace.restart(7_000_000)
    assert pace.wait_s(7_250_000) == pytest.approx(0.25)
