"""Vehicle time follows stamps, at any speed."""

import pytest

from flightstack.clock import ClockLine, VehicleClock


class Wall:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_unknown_before_the_first_stamp() -> None:
    clock = VehicleClock(Wall())
    assert not clock.started
    assert (clock.stamp_us, clock.elapsed_us, clock.now_us()) == (0, 0, 0)


def test_bridges_the_gap_between_stamps_by_the_wall() -> None:
    wall = Wall()
    clock = VehicleClock(wall)
    clock.observe(5_000_000)
    wall.now_s += 0.25
    assert clock.now_us() == 5_250_000
    assert clock.stamp_us == 5_000_000


def test_counts_from_the_first_stamp() -> None:
    clock = VehicleClock(Wall())
    clock.observe(5_000_000)
    clock.observe(7_500_000)
    assert clock.elapsed_us == 2_500_000


def test_a_message_out_of_order_changes_nothing() -> None:
    clock = VehicleClock(Wall())
    clock.observe(5_000_000)
    clock.observe(4_980_000)
    clock.observe(3_000_000)  # telemetry on a slow line, far behind a camera's stamps
    assert clock.stamp_us == 5_000_000


def test_follows_a_reboot() -> None:
    clock = VehicleClock(Wall())
    clock.observe(60_000_000)
    clock.observe(20_000)
    assert (clock.stamp_us, clock.elapsed_us) == (20_000, 0)


@pytest.mark.parametrize("vehicle_us", [0.0, 60e6, 9.2e15])
def test_a_line_that_no_telemetry_agrees_with_is_not_believed(vehicle_us: float) -> None:
    clock = VehicleClock(Wall())
    clock.observe(20_000_000)
    clock.synchronise(ClockLine(100.0, vehicle_us, 1.0))
    assert not clock.synchronised
    assert clock.now_us() == 20_000_000


def test_a_line_tells_any_moment_until_telemetry_is_ahead_of_it() -> None:
    wall = Wall()
    clock = VehicleClock(wall)
    clock.observe(5_000_000)
    clock.synchronise(ClockLine(100.0, 5_080_000.0, 1.0))  # telemetry was 80 ms on its way
    assert clock.at_us(99.5) == 4_580_000
    clock.observe(5_100_000)
    assert clock.now_us() == 5_080_000
    clock.observe(5_200_000)  # telemetry cannot be early: the vehicle's clock runs otherwise
    assert not clock.synchronised
    assert clock.now_us() == 5_200_000
