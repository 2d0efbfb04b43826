"""Missions flown in process: the heading that an item asks for."""

import math

import pytest

from sitl.frames import yaw_of
from sitl.records.modes import Mode
from tests.unit.sitl.autopilot.conftest import NAN, Flight
from tests.unit.sitl.autopilot.flight_modes.made_plans import LOITER_TIME, WAYPOINT, place
from tests.unit.sitl.autopilot.flight_modes.mission_run import MissionRun


@pytest.fixture
def run(flight: Flight) -> MissionRun:
    return MissionRun(flight)


def test_it_turns_to_the_heading_of_an_item(run: MissionRun) -> None:
    run.in_air()
    run.upload(place(WAYPOINT, 0.0, 0.0, 6.0, 0.0, 1.0, NAN, 90.0))
    run.go()
    assert 3.0 < run.run_until_reached(0, timeout_s=8.0) < 6.0  # 90 deg at 20 deg/s2
    run.flight.run(2.0)
    assert yaw_of(run.flight.estimate.q_ned_frd) == pytest.approx(math.pi / 2, abs=0.05)


@pytest.mark.parametrize(
    ("name", "value", "command", "required", "least_s", "most_s"),
    [
        ("MIS_YAW_ERR", 80.0, WAYPOINT, 1.0, 1.0, 2.5),
        ("MIS_YAW_TMT", 5.0, WAYPOINT, 1.0, 0.0, 0.5),
        ("MIS_YAW_TMT", 5.0, LOITER_TIME, 0.0, 0.0, 0.5),
        ("MIS_YAW_TMT", 5.0, LOITER_TIME, 1.0, 3.0, 6.0),  # this heading is forced
    ],
)
def test_how_long_it_waits_for_a_heading(
    run: MissionRun,
    name: str,
    value: float,
    command: int,
    required: float,
    least_s: float,
    most_s: float,
) -> None:
    run.flight.parameters.set(name, value)
    run.in_air()
    run.upload(place(command, 0.0, 0.0, 6.0, 0.0, required, NAN, 90.0))
    run.go()
    assert least_s <= run.run_until_reached(0, timeout_s=8.0) < most_s


def test_a_forced_heading_that_comes_too_late_fails_the_mission(run: MissionRun) -> None:
    """PX4 says so, holds for COM_FAIL_ACT_T and returns, until there is another mission."""
    run.flight.parameters.set("MIS_YAW_TMT", 2.0)  # 90 deg at 20 deg/s2 take more than 3 s
    run.in_air()
    item = place(LOITER_TIME, 0.0, 0.0, 6.0, 10.0, 1.0, NAN, 90.0)
    run.upload(item)
    run.go()
    run.flight.run(1.9)
    assert run.mode is Mode.MISSION
    run.flight.run(0.2)
    assert "2:unable to reach heading within timeout" in run.flight.said
    assert run.mode is Mode.HOLD
    run.flight.run(4.8)
    assert run.mode is Mode.HOLD
    run.flight.run(0.2)
    assert run.mode is Mode.RTL
    assert run.items == []
    run.upload(item)
    run.step()
    assert run.mode is Mode.MISSION
