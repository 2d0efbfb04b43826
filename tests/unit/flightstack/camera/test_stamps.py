"""Stamps are believed while they can be the vehicle's time."""

import numpy as np
import pytest

from flightstack.camera.mailbox import Arrival
from flightstack.camera.stamps import StampCheck
from flightstack.clock import VehicleClock
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
