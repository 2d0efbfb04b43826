"""Moved sticks end automatic flight, and OFFBOARD where COM_RC_OVERRIDE says so."""

import pytest

from sitl.records.modes import Mode
from sitl.records.vehicle import Sticks
from tests.unit.sitl.autopilot.conftest import Flight

TOOK_OVER = "6:Pilot took over using sticks"
HOLD, OFFBOARD = (4, 3), (6, 0)


class Pilot:
    """Holds the sticks, sent at 25 Hz, over a vehicle that hovers at 10 m."""

    def __init__(self, flight: Flight) -> None:
        self.flight = flight
        flight.place((0.0, 0.0, -10.0))
        flight.send(velocity_ned=(0.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
        self.hold(1.0)

    def hold(self, seconds: float, **axes: float) -> None:
        axes = dict.fromkeys(("forward", "right", "up", "turn"), 0.0) | axes
        for _ in range(round(seconds * 25)):
            time_us = self.flight.time_us
            self.flight.autopilot.manual_control(Sticks(time_us=time_us, **axes))
            self.flight.run(0.04)

    @property
    def mode(self) -> Mode:
        return self.flight.autopilot.status.mode


@pytest.fixture
def pilot(flight: Flight) -> Pilot:
    return Pilot(flight)


@pytest.mark.parametrize(
    ("override", "mode", "taken"),
    [
        (0, HOLD, False),
        (1, HOLD, True),
        (2, HOLD, False),
        (3, HOLD, True),
        (0, OFFBOARD, False),
        (1, OFFBOARD, False),  # PX4's default: automatic modes only
        (2, OFFBOARD, True),
        (3, OFFBOARD, True),
    ],
)
@pytest.mark.parametrize("axis", ["forward", "right", "up", "turn"])
def test_a_moved_stick_takes_over_where_allowed(
    pilot: Pilot, override: int, mode: tuple[int, int], axis: str, *, taken: bool
) -> None:
    flight = pilot.flight
    flight.parameters.set("COM_RC_OVERRIDE", override)
    flight.autopilot.set_mode(*mode)
    pilot.hold(0.2)
    before = pilot.mode
    pilot.hold(0.2, **{axis: -0.5})
    assert pilot.mode is (Mode.POSCTL if taken else before)
    assert (TOOK_OVER in flight.said) is taken


def test_the_threshold_is_that_of_the_parameter(pilot: Pilot) -> None:
    pilot.flight.autopilot.set_mode(*HOLD)
    pilot.hold(1.0, forward=0.29)
    assert pilot.mode is Mode.HOLD
    pilot.flight.parameters.set("COM_RC_STICK_OV", 10.0)
    pilot.hold(2.0)
    pilot.hold(0.1, forward=0.15)
    assert pilot.mode is Mode.POSCTL


def test_a_stick_that_rests_anywhere_does_not_take_over(pilot: Pilot) -> None:
    """The throttle of a joystick without a spring may rest at its lower end."""
    pilot.flight.parameters.set("COM_RC_OVERRIDE", 0)
    pilot.hold(6.0, up=-1.0)
    pilot.flight.autopilot.set_mode(*HOLD)
    pilot.flight.parameters.set("COM_RC_OVERRIDE", 1)
    pilot.hold(1.0, up=-1.0)
    assert pilot.mode is Mode.HOLD
    pilot.hold(0.1, up=-0.5)
    assert pilot.mode is Mode.POSCTL


def test_sticks_that_are_switched_on_in_flight_do_not_take_over(flight: Flight) -> None:
    flight.place((0.0, 0.0, -10.0))
    flight.autopilot.set_mode(*HOLD)
    flight.run(1.0)
    for _ in range(10):
        flight.autopilot.manual_control(
            Sticks(time_us=flight.time_us, forward=0.0, right=0.0, up=-1.0, turn=0.0)
        )
        flight.run(0.04)
    assert flight.autopilot.status.mode is Mode.HOLD


def test_on_the_ground_moved_sticks_change_no_mode(flight: Flight) -> None:
    flight.run(2.0)
    for forward in (0.0, 1.0, 0.0, 1.0):
        flight.autopilot.manual_control(
            Sticks(time_us=flight.time_us, forward=forward, right=0.0, up=0.0, turn=0.0)
        )
        flight.run(0.04)
    assert flight.autopilot.status.mode is Mode.HOLD
