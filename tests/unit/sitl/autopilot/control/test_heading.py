"""A heading turns within its limits, comes to rest where it was sent, and follows a stream."""

import itertools
import math

import pytest

from sitl.autopilot.control.heading import FacingParameters, Heading, HeadingParameters
from sitl.autopilot.parameters import Parameters
from sitl.clock import TICK_S
from sitl.frames import wrap_pi

PARAMETERS = HeadingParameters.resolve(Parameters().values)


@pytest.mark.parametrize("wanted_deg", [3.0, 50.0, -170.0])
def test_turns_within_its_limits_and_comes_to_rest(wanted_deg: float) -> None:
    heading, wanted, rates = Heading(), math.radians(wanted_deg), [0.0]
    for _ in range(2500):
        heading = heading.turn(wanted, PARAMETERS)
        rates.append(heading.rate_rad_s)
        assert abs(heading.yaw_rad) <= abs(wanted) + 1e-4
    assert heading.yaw_rad == pytest.approx(wanted)
    assert heading.rate_rad_s == 0.0
    assert max(map(abs, rates)) <= math.radians(60.0)  # MPC_YAWRAUTO_MAX
    changes = [abs(b - a) for a, b in itertools.pairwise(rates)]
    assert max(changes[:-1]) <= math.radians(20.0) * TICK_S * 1.01  # MPC_YAWRAUTO_ACC


def test_turns_the_short_way_round() -> None:
    heading = Heading(math.radians(170.0))
    for _ in range(2500):
        heading = heading.turn(math.radians(-170.0), PARAMETERS)
        assert abs(wrap_pi(heading.yaw_rad - math.pi)) < math.radians(10.1)


def test_a_turn_that_is_given_up_ends_where_it_can() -> None:
    heading = Heading()
    for _ in range(400):
        heading = heading.turn(2.0, PARAMETERS)
    end = heading.rest_rad(PARAMETERS)
    for _ in range(2500):
        heading = heading.turn(end, PARAMETERS)
    assert heading.yaw_rad == pytest.approx(end)
    assert end < 2.0


def test_a_smooth_stream_is_taken_as_it_is_and_a_jump_is_not() -> None:
    heading = Heading()
    for step in range(50):
        heading = heading.follow(0.01 * step, PARAMETERS)
        assert heading.yaw_rad == 0.01 * step
        assert heading.rate_rad_s == 0.0
    heading = heading.follow(2.0, PARAMETERS)
    assert heading.yaw_rad < 0.5
    for _ in range(2500):
        heading = heading.follow(2.0, PARAMETERS)
    heading = heading.follow(2.05, PARAMETERS)
    assert heading.yaw_rad == 2.05


@pytest.mark.parametrize(
    ("timeout_s", "forced", "off_deg", "accepted"),
    [
        (-1.0, False, 11.9, True),  # as it comes: MIS_YAW_ERR 12
        (-1.0, False, -12.1, False),
        (-1.0, True, 12.1, False),
        (0.0, False, 12.1, False),
        (0.1, False, 180.0, True),
        (20.0, True, 12.1, False),
        (20.0, True, -11.9, True),
    ],
)
def test_a_heading_is_waited_for_unless_there_is_a_timeout(
    timeout_s: float, off_deg: float, *, forced: bool, accepted: bool
) -> None:
    facing = FacingParameters.resolve(Parameters({"MIS_YAW_TMT": timeout_s}).values)
    wanted = math.radians(175.0)
    yaw = wrap_pi(wanted + math.radians(off_deg))
    assert facing.accepts(wanted, yaw, forced=forced) is accepted
    assert facing.accepts(math.nan, yaw, forced=forced)
