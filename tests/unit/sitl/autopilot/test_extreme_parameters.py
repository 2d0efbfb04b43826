"""Every value that a parameter may have is one that the vehicle goes on with, however it flies."""

import math

import pytest

from sitl.autopilot.parameters import Parameters
from tests.unit.sitl.autopilot.conftest import NAN, Flight

DO_REPOSITION, DO_SET_MODE, RETURN_TO_LAUNCH, LAND = 192, 176, 20, 21
PARAMETERS = Parameters()


def extremes_of(name: str) -> list[float]:
    allowed = PARAMETERS.specification(name)
    values = {allowed.minimum, allowed.maximum, 0.0}
    return [value for value in values if allowed.minimum <= value <= allowed.maximum]


def fly_about(flight: Flight) -> None:
    """Go by velocity, to a place, home and down, a little each."""
    flight.send(velocity_ned=(3.0, 1.0, -0.5), yaw_rate_rad_s=0.5)
    flight.run(0.4)
    flight.stream = None
    flight.command(DO_REPOSITION, -1.0, 1.0, 0.0, NAN, 47.398, 8.5459, 505.0)
    flight.run(0.3)
    for command in (RETURN_TO_LAUNCH, LAND):
        flight.command(command)
        flight.run(0.2)


@pytest.mark.parametrize("name", PARAMETERS.names())
def test_a_value_that_is_allowed_can_be_flown_with(flight: Flight, name: str) -> None:
    for value in extremes_of(name):
        flight.place((0.0, 0.0, -10.0))
        flight.parameters.set(name, value)
        fly_about(flight)
        state = (*flight.estimate.position_ned, *flight.estimate.q_ned_frd)
        assert all(math.isfinite(number) for number in state), (name, value)
