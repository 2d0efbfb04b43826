"""Missions flown in process: where it goes, how long it takes, what it says."""

import math
from dataclasses import replace

import pytest

from sitl.records.missions import MissionState, PlanKind
from sitl.records.modes import Mode
from tests.unit.sitl.autopilot.conftest import HOME, NAN, Flight
from tests.unit.sitl.autopilot.flight_modes.made_plans import (
    ABSOLUTE,
    DELAY,
    JUMP,
    LAND,
    LOITER_TIME,
    LOITER_TO_ALTITUDE,
    LOITER_UNLIMITED,
    REGION_OF_INTEREST,
    RETURN,
    SPEED,
    TAKEOFF,
    WAYPOINT,
    deed,
    place,
)
from tests.unit.sitl.autopilot.flight_modes.mission_run import MissionRun

ARM, SET_MODE, MISSION_START, PAUSE, GO_TO_ITEM, REPOSITION = 400, 176, 300, 193, 224, 192
CHANGE_SPEED, GO_HOME = 178, 20
ACCEPTED, REJECTED, DENIED = 0, 1, 2
SQUARE = ((6.0, 0.0), (6.0, 6.0), (0.0, 6.0), (0.0, 0.0))


@pytest.fixture
def run(flight: Flight) -> MissionRun:
    return MissionRun(flight)


def test_a_square_and_home_again(run: MissionRun) -> None:
    waypoints = [place(WAYPOINT, *corner, 6.0, 0.5, 1.0) for corner in SQUARE]
    run.upload(*waypoints, deed(RETURN))
    run.flight.run(1.2)
    assert run.missions.progress == (0, 5, MissionState.NOT_STARTED, False)
    run.start()
    assert run.state is MissionState.ACTIVE
    assert run.flight.said[1:] == [
        "6:Armed by mission start",
        "6:Executing Mission",
        "6:Climb to 6.0 meters above home",
    ]
    returns_s = run.run_until_reached(4, timeout_s=40.0)
    assert 24.0 < returns_s < 30.0  # a PX4 with more drag and noise was seen to take 27 to 29 s
    for (north, east), (item, _, where) in zip(SQUARE, run.reached[:4], strict=True):
        assert math.dist((north, east), where[:2]) < 1.0
        assert abs(where[2] + 6.0) < 0.8
        assert run.items[item] == item
    run.step()
    assert run.mode is Mode.RTL
    assert run.state is MissionState.COMPLETE
    landed_s = run.flight.run_until(
        lambda: not run.flight.autopilot.status.armed, timeout_s=returns_s + 20.0
    )
    assert 15.0 < landed_s < 21.0  # a PX4 was seen to take 20 s
    assert math.hypot(*run.flight.estimate.position_ned[:2]) < 0.3
    assert run.flight.said[-2:] == ["6:Landing detected", "6:Disarmed by landing"]


def test_the_mode_may_be_chosen_first_and_arming_starts_the_mission(run: MissionRun) -> None:
    run.upload(place(TAKEOFF, 0.0, 0.0, 5.0), place(WAYPOINT, 8.0, 0.0, 5.0))
    run.flight.run(1.1)
    assert run.flight.command(SET_MODE, 1.0, 4.0, 4.0) == ACCEPTED
    run.flight.run(0.1)
    assert (run.mode, run.flight.autopilot.status.armable) == (Mode.MISSION, True)
    assert run.flight.command(ARM, 1.0) == ACCEPTED
    run.run_until_reached(1, timeout_s=20.0)
    run.step()
    run.flight.run(4.0)
    assert run.flight.said[1:] == [
        "6:Armed by external command",
        "6:Executing Mission",
        "6:Climb to 5.0 meters above home",
        "6:Takeoff detected",
        "6:Mission finished, loitering",
    ]
    assert run.mode is Mode.MISSION
    assert math.dist(run.flight.estimate.position_ned, (8.0, 0.0, -5.0)) < 0.3


def test_right_after_an_upload_in_flight_a_start_is_refused(run: MissionRun) -> None:
    run.in_air()
    plan = (place(WAYPOINT, 8.0, 0.0, 6.0),)
    run.missions.replace(PlanKind.MISSION, plan, 0)
    for _ in range(24):  # 100 ms
        assert run.flight.command(SET_MODE, 1.0, 4.0, 4.0) == REJECTED
        run.step()
    assert run.flight.said == ["2:Switching to Mission is currently not available"] * 24
    run.step()
    assert run.flight.command(SET_MODE, 1.0, 4.0, 4.0) == ACCEPTED
    run.step()
    assert run.mode is Mode.MISSION


def test_no_mission_no_start(run: MissionRun) -> None:
    run.in_air()
    assert run.flight.command(MISSION_START, 0.0) == DENIED
    assert run.flight.command(SET_MODE, 1.0, 4.0, 4.0) == REJECTED
    assert run.flight.command(GO_TO_ITEM, 0.0) == DENIED
    assert run.flight.command(PAUSE, 1.0) == DENIED
    run.step()
    assert run.flight.said == [
        "2:Mission start denied! No valid mission",
        "2:Switching to Mission is currently not available",
    ]
    assert run.state is MissionState.NO_MISSION


def test_a_mission_does_not_begin_far_away(run: MissionRun) -> None:
    run.in_air()
    run.upload(place(WAYPOINT, 10_100.0, 0.0), place(WAYPOINT, 1.0, 0.0))
    assert run.flight.command(MISSION_START, 0.0) == DENIED
    run.step()
    run.flight.parameters.set("NAV_ACC_RAD", 3.0)
    run.step()
    assert run.flight.said == [
        "2:First waypoint too far away: 10100m, 10000 max",
        "2:Mission start denied! No valid mission",
    ]
    run.flight.parameters.set("MIS_DIST_1WP", -1.0)
    run.step()
    assert run.flight.command(MISSION_START, 0.0) == ACCEPTED


def test_times_of_waiting(run: MissionRun) -> None:
    run.in_air()
    run.upload(
        place(WAYPOINT, 0.0, 0.0, 6.0, 1.5),
        deed(REGION_OF_INTEREST),
        deed(DELAY, 2.0),
        place(LOITER_TIME, 0.0, 0.0, 6.0, 1.0),
        place(LOITER_UNLIMITED, 0.0, 0.0, 6.0),
        place(WAYPOINT, 9.0, 9.0),
    )
    run.go()
    run.run_until_reached(3, timeout_s=6.0)
    at = [seconds for _, seconds, _ in run.reached]
    assert at == pytest.approx([1.5, 1.5, 3.5, 4.5], abs=0.02)
    run.flight.run(10.0)
    assert run.missions.progress == (4, 6, MissionState.ACTIVE, True)


def test_jumps_are_counted(run: MissionRun) -> None:
    run.in_air()
    run.upload(place(WAYPOINT, 0.0, 0.0, 6.0), place(WAYPOINT, 1.0, 0.0, 6.0), deed(JUMP, 0.0, 2.0))
    run.go()
    run.flight.run(2.0)
    run.step()
    assert run.items == [0, 1, 2] * 3
    assert run.flight.said == ["6:Executing Mission", "6:Mission finished, loitering"]


def test_jumps_without_an_end_end(run: MissionRun) -> None:
    run.in_air()
    run.upload(deed(JUMP, 0.0, -1.0))
    run.go()
    assert run.state is MissionState.COMPLETE
    run.flight.run(1.0)
    assert math.dist(run.flight.estimate.position_ned, (0.0, 0.0, -6.0)) < 0.1


@pytest.mark.parametrize("by_command", [False, True])
def test_changes_of_speed(run: MissionRun, by_command: bool) -> None:  # noqa: FBT001
    run.in_air()
    speed = () if by_command else (deed(SPEED, 1.0, 2.0),)
    run.upload(*speed, place(WAYPOINT, 40.0, 0.0))
    run.go()
    if by_command:
        assert run.flight.command(CHANGE_SPEED, 1.0, 2.0) == ACCEPTED
    run.flight.run(4.0)
    assert run.flight.estimate.velocity_ned[0] == pytest.approx(2.0, abs=0.1)
    assert run.flight.command(CHANGE_SPEED, 1.0, -1.0) == ACCEPTED
    assert run.flight.command(CHANGE_SPEED, 1.0, NAN) == DENIED
    assert run.flight.command(CHANGE_SPEED, 7.0, 2.0) == DENIED
    run.flight.run(4.0)
    expected = 5.0 if by_command else 2.0  # -1 takes the command back, not the mission's item
    assert run.flight.estimate.velocity_ned[0] == pytest.approx(expected, abs=0.2)


def test_a_mission_is_paused_and_goes_on_where_it_was(run: MissionRun) -> None:
    run.in_air()
    run.upload(place(WAYPOINT, 0.0, 0.0), place(WAYPOINT, 20.0, 0.0), place(WAYPOINT, 20.0, 20.0))
    run.go()
    run.flight.run(2.5)
    assert run.flight.command(PAUSE, 0.0) == ACCEPTED
    run.flight.run(4.0)
    assert (run.mode, run.state) == (Mode.HOLD, MissionState.PAUSED)
    here = run.flight.estimate.position_ned
    run.flight.run(2.0)
    assert math.dist(run.flight.estimate.position_ned, here) < 0.1
    assert run.flight.command(PAUSE, 1.0) == ACCEPTED
    assert run.flight.command(PAUSE, 7.0) == DENIED
    assert run.missions.progress.sequence == 1
    run.run_until_reached(1, timeout_s=10.0)
    assert run.items == [0, 1]


def test_going_to_an_item_and_a_new_mission_in_flight(run: MissionRun) -> None:
    run.in_air()
    run.upload(*(place(WAYPOINT, 20.0 * n, 0.0) for n in range(1, 4)))
    run.go()
    run.flight.run(1.0)
    assert run.flight.command(GO_TO_ITEM, 2.0) == ACCEPTED
    assert run.flight.command(GO_TO_ITEM, 3.0) == DENIED
    assert run.flight.command(GO_TO_ITEM, NAN) == DENIED
    run.flight.run(1.0)
    assert run.missions.progress.sequence == 2
    run.upload(place(WAYPOINT, 99.0, 0.0), place(WAYPOINT, 0.0, 3.0), current=1)
    run.run_until_reached(1, timeout_s=10.0)
    assert run.items == [1]
    run.upload()
    run.flight.run(3.0)
    assert run.state is MissionState.NO_MISSION
    assert run.flight.estimate.position_ned[2] == pytest.approx(-6.0, abs=0.3)


def test_it_lands_where_the_mission_says_and_begins_anew(run: MissionRun) -> None:
    run.upload(place(TAKEOFF, 0.0, 0.0, 3.0), place(LAND, 4.0, 2.0, 0.0))
    run.start()
    run.flight.run_until(lambda: not run.flight.autopilot.status.armed, timeout_s=40.0)
    run.step()
    assert run.items == [0, 1]
    assert run.state is MissionState.COMPLETE
    assert math.dist(run.flight.estimate.position_ned[:2], (4.0, 2.0)) < 0.3
    assert "6:Mission finished, landed" in run.flight.said
    assert run.flight.command(MISSION_START, 0.0) == ACCEPTED
    run.step()
    assert run.missions.progress == (0, 2, MissionState.ACTIVE, True)


@pytest.mark.parametrize("command", [WAYPOINT, LOITER_TO_ALTITUDE])
def test_altitudes_above_mean_sea_level(run: MissionRun, command: int) -> None:
    run.in_air()
    above_sea = replace(place(command, 0.0, 0.0), frame=ABSOLUTE, z=HOME[2] + 9.0)
    run.upload(above_sea)
    run.go()
    run.run_until_reached(0, timeout_s=8.0)
    run.flight.run(4.0)
    assert run.flight.height_m == pytest.approx(9.0, abs=0.2)
