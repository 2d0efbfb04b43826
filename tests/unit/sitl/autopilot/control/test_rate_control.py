"""The rate controller, axis by axis."""

import math

import pytest

from sitl.autopilot.control.rate_control import RateControl, RateParameters
from sitl.autopilot.parameters import Parameters

STILL = (0.0, 0.0, 0.0)
VALUES = Parameters().values
PARAMETERS = RateParameters.resolve(VALUES)


@pytest.fixture
def control() -> RateControl:
    return RateControl()


def hold(
    control: RateControl,
    wanted: tuple[float, float, float],
    ticks: int,
    *,
    saturated: tuple[float, float, float] = STILL,
    landed: bool = False,
) -> tuple[float, float, float]:
    """Ask for rates that are never reached; the torque at the end."""
    for _ in range(ticks):
        torque = control.update(STILL, wanted, PARAMETERS, saturated=saturated, landed=landed)
    return torque


@pytest.mark.parametrize(("axis", "letters"), [(0, "ROLL"), (1, "PITCH")])
def test_an_error_that_stays_adds_up_to_its_limit(
    control: RateControl, axis: int, letters: str
) -> None:
    x, y, z = (0.5 if index == axis else 0.0 for index in range(3))
    wanted = (x, y, z)
    gain, limit = VALUES[f"MC_{letters}RATE_P"], VALUES[f"MC_{letters[0]}R_INT_LIM"]
    assert hold(control, wanted, 1)[axis] == pytest.approx(gain * 0.5)
    assert hold(control, wanted, 5000)[axis] == pytest.approx(gain * 0.5 + limit)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_nothing_adds_up_against_a_torque_that_the_mixer_cut(
    control: RateControl, axis: int
) -> None:
    x, y, z = (0.5 if index == axis else 0.0 for index in range(3))
    wanted = (x, y, z)
    first = hold(control, wanted, 500, saturated=wanted)
    assert hold(control, wanted, 500, saturated=wanted) == pytest.approx(first)
    the_other_way = (-x, -y, -z)
    assert hold(control, wanted, 500, saturated=the_other_way)[axis] > first[axis]


def test_nothing_adds_up_on_the_ground_nor_of_an_error_too_large(control: RateControl) -> None:
    assert hold(control, (0.5, 0.0, 0.0), 500, landed=True)[0] == pytest.approx(
        hold(control, (0.5, 0.0, 0.0), 1, landed=True)[0]
    )
    hold(control, (math.radians(500.0), 0.0, 0.0), 500)
    assert hold(control, STILL, 1) == pytest.approx(STILL)


def test_a_reset_forgets(control: RateControl) -> None:
    hold(control, (0.5, 0.5, 0.5), 500)
    control.reset()
    assert hold(control, STILL, 1) == STILL


def test_a_turn_that_quickens_is_braked_by_d(control: RateControl) -> None:
    control.update(STILL, STILL, PARAMETERS, saturated=STILL, landed=False)
    roll, pitch, _ = control.update(
        (0.1, -0.1, 0.0), (0.1, -0.1, 0.0), PARAMETERS, saturated=STILL, landed=False
    )
    assert roll < 0.0 < pitch
