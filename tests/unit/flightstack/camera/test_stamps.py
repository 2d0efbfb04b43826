"""Stamps are believed while they can be the vehicle's time."""

from dataclasses import replace

import numpy as np
import pytest

from flightstack.camera.mailbox import Arrival
from flightstack.camera.stamps import StampCheck
from flightstack.clock import ClockLine, VehicleClock
from flightstack.records import Image


def arrival(stamp_us: int, *, received_s: float = 0.0) -> Arrival:
    rgb = np.zeros((2, 2, 3), np.uint8)
    return Arrival(Image(stamp_us=stamp_us, sequence=0, rgb=rgb), received_s)


@pytest.fixture
def clock() -> VehicleClock:
    clock = VehicleClock(lambda: 0.25)
    clock.observe(200_000_000)
    return clock


@pytest.mark.parametrize("offset_s", [-4.9, -0.5, 0.0, 0.052, 1.9])
def test_what_can_be_the_vehicles_time_stays(clock: VehicleClock, offset_s: float) -> None:
    check, came = StampCheck(clock), arrival(200_000_000 + round(offset_s * 1e6))
    assert check.admit(came) is came
    assert check.complaint == ""


@pytest.mark.parametrize(
    ("offset_s", "complaint"),
    [(10.0, "ahead"), (4e6, "ahead"), (-100.0, "behind"), (-199.9, "behind")],
)
def test_what_cannot_be_is_dated_by_arrival(
    clock: VehicleClock, offset_s: float, complaint: str
) -> None:
    check = StampCheck(clock)
    admitted = check.admit(arrival(200_000_000 + round(offset_s * 1e6), received_s=0.2))
    assert (admitted.image.stamp_us, admitted.stamped) == (199_950_000, False)
    assert complaint in check.complaint


def test_an_image_that_the_vehicle_has_announced_has_the_time_of_that(clock: VehicleClock) -> None:
    check = StampCheck(clock)
    first, again = (check.admit(arrival(10**15), 199_990_000) for _ in range(2))
    assert (first.image.stamp_us, first.stamped) == (199_990_000, True)
    assert not again.stamped
    assert not check.admit(arrival(10**15), 150_000_000).stamped


def test_a_stamp_before_any_telemetry_is_believed() -> None:
    came = arrival(900_000_000)
    assert StampCheck(VehicleClock()).admit(came) is came


def undated(clock: VehicleClock, received_s: float, taken_s: float | None = None) -> Arrival:
    image = replace(arrival(0).image, stamp_us=clock.at_us(received_s))
    return Arrival(image, received_s, stamped=False, taken_s=taken_s)


def test_an_image_without_a_stamp_is_dated_by_its_sensor_less_the_latency(
    clock: VehicleClock,
) -> None:
    clock.synchronise(ClockLine(0.25, 200e6, 1.0))
    check = StampCheck(clock, latency_s=0.03)
    by_arrival = check.admit(undated(clock, 0.2))
    by_sensor = check.admit(undated(clock, 0.25, taken_s=0.23))
    assert [a.image.stamp_us for a in (by_arrival, by_sensor)] == [199_920_000, 199_950_000]
    assert [check.aged(a).age_s for a in (by_arrival, by_sensor)] == pytest.approx([0.03, 0.05])


def test_images_stay_in_order_when_the_clock_is_put_right(clock: VehicleClock) -> None:
    check = StampCheck(clock)
    first = check.admit(undated(clock, 0.25)).image.stamp_us
    clock.synchronise(ClockLine(0.25, 199.9e6, 1.0))
    assert check.admit(undated(clock, 0.3)).image.stamp_us == first + 1
    assert check.admit(undated(clock, 0.45)).image.stamp_us == 200_100_000


def test_a_stamped_image_is_as_old_as_telemetry_proves(clock: VehicleClock) -> None:
    check = StampCheck(clock)
    assert check.aged(arrival(200_000_000)).age_s == 0.0  # as in lockstep
    assert check.aged(arrival(199_900_000)).age_s == pytest.approx(0.1)
    clock.synchronise(ClockLine(0.0, 200.02e6, 1.0))
    assert check.aged(arrival(200_000_000)).age_s == pytest.approx(0.02)


@pytest.mark.parametrize("since", [1_733_050_000.0, 86_400.0])  # 1970, or the camera's own start
def test_a_camera_with_a_clock_of_its_own_is_dated_by_it_without_the_networks_jitter(
    clock: VehicleClock, since: float
) -> None:
    clock.synchronise(ClockLine(0.0, 200e6, 1.0))
    check = StampCheck(clock)
    dated_us = []
    for number, delay_s in enumerate((0.0, 0.03, 0.01)):
        taken_s = number / 20
        told = Arrival(
            arrival(0).image, taken_s + delay_s, stamped=False, odd_stamp=f"{since + taken_s:.6f}"
        )
        dated_us.append(check.admit(told).image.stamp_us)
    assert dated_us == pytest.approx([200_000_000, 200_050_000, 200_100_000], abs=2)


@pytest.mark.parametrize("told", ["nan", "-inf", "1e300", "noon"])
def test_what_is_no_time_at_all_says_nothing(clock: VehicleClock, told: str) -> None:
    check = StampCheck(clock)
    came = check.admit(Arrival(arrival(0).image, 0.2, stamped=False, odd_stamp=told))
    assert came.image.stamp_us == 199_950_000
