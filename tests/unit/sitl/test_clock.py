import itertools

import pytest

from sitl.clock import SECOND_US, TICK_US, Schedule


def due_times(schedule: Schedule, until_us: int) -> list[int]:
    return [t for t in range(0, until_us, TICK_US) if schedule.due(t)]


def test_20_hz_comes_every_12_or_13_ticks_and_averages_exactly_20_hz() -> None:
    times = due_times(Schedule(20), 10 * SECOND_US)
    assert len(times) == 200
    gaps = {b - a for a, b in itertools.pairwise(times)}
    assert gaps == {48_000, 52_000}
    assert times[:4] == [0, 52_000, 100_000, 152_000]


@pytest.mark.parametrize(
    ("rate_hz", "count"), [(250, 2500), (100, 1000), (50, 500), (30, 300), (0.5, 5), (0.1, 1)]
)
def test_rate_is_exact_over_10_s(rate_hz: float, count: int) -> None:
    assert len(due_times(Schedule(rate_hz), 10 * SECOND_US)) == count


def test_faster_than_a_tick_is_due_every_tick() -> None:
    assert len(due_times(Schedule(1000), SECOND_US)) == 250


def test_missed_times_merge_and_the_phase_holds() -> None:
    schedule = Schedule(10)
    assert schedule.due(0)
    assert schedule.due(350_000)
    assert not schedule.due(396_000)
    assert schedule.due(400_000)


def test_starts_at_its_start() -> None:
    schedule = Schedule(10, start_us=1_000_000)
    assert not schedule.due(996_000)
    assert schedule.due(1_000_000)
    assert schedule.next_due_us == 1_100_000


@pytest.mark.parametrize("rate_hz", [0, -1])
def test_refuses_a_rate_that_is_not_positive(rate_hz: float) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        Schedule(rate_hz)
