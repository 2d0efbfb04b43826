"""The geofence as geometry, and what a vehicle does that leaves it."""

import pytest

from sitl.autopilot.flight_modes.geofence import (
    ALTITUDE,
    AREA,
    DISTANCE,
    FenceParameters,
    Geofence,
)
from sitl.autopilot.parameters import Parameters
from sitl.records.missions import MissionItem, MissionResult, PlanKind
from sitl.records.modes import Mode
from tests.unit.sitl.autopilot.conftest import HOME, NAN, Flight
from tests.unit.sitl.autopilot.flight_modes.made_plans import (
    CIRCLE_EXCLUSION,
    CIRCLE_INCLUSION,
    POLYGON_EXCLUSION,
    POLYGON_INCLUSION,
    WAYPOINT,
    circle,
    place,
    polygon,
)

ARM, MISSION_START, REPOSITION = 400, 300, 192
ACCEPTED, REJECTED, DENIED = 0, 1, 2
SQUARE = ((10.0, 10.0), (10.0, -10.0), (-10.0, -10.0), (-10.0, 10.0))
ELL = ((0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (10.0, 10.0), (10.0, 20.0), (0.0, 20.0))
HOME_NED = (0.0, 0.0, 0.0)


def make_fence(**limits: float) -> Geofence:
    return Geofence(FenceParameters.resolve(Parameters(limits).values), HOME)


@pytest.mark.parametrize(
    ("plan", "inside", "outside"),
    [
        ((), [(1e6, 1e6)], []),
        (polygon(POLYGON_INCLUSION, *SQUARE), [(0, 0), (9.9, -9.9)], [(10.1, 0), (0, 11), (99, 9)]),
        (polygon(POLYGON_INCLUSION, *reversed(SQUARE)), [(0, 0)], [(10.1, 0)]),
        (polygon(POLYGON_EXCLUSION, *SQUARE), [(10.1, 0), (50, 50)], [(0, 0), (-9.9, 9.9)]),
        (polygon(POLYGON_INCLUSION, *ELL), [(5, 15), (15, 5)], [(15, 15), (-1, 5)]),
        ((circle(CIRCLE_INCLUSION, 5.0, 5.0, 3.0),), [(5, 7.9)], [(5, 8.1), (0, 0)]),
        ((circle(CIRCLE_EXCLUSION, 5.0, 5.0, 3.0),), [(5, 8.1), (0, 0)], [(5, 7.9)]),
        (
            (*polygon(POLYGON_INCLUSION, *SQUARE), circle(CIRCLE_EXCLUSION, 0.0, 0.0, 2.0)),
            [(5, 5)],
            [(0, 0), (11, 0)],
        ),
        (  # all of them hold together
            (circle(CIRCLE_INCLUSION, 0.0, 0.0, 10.0), circle(CIRCLE_INCLUSION, 15.0, 0.0, 10.0)),
            [(7, 0)],
            [(0, 0), (15, 0)],
        ),
    ],
)
def test_areas(
    plan: tuple[MissionItem, ...],
    inside: list[tuple[float, float]],
    outside: list[tuple[float, float]],
) -> None:
    fence = make_fence()
    fence.take(plan)
    for north, east in inside:
        assert fence.judge((north, east, -5.0), HOME_NED) is None
    for north, east in outside:
        assert fence.judge((north, east, -5.0), HOME_NED) == AREA


def test_limits_around_home() -> None:
    fence = make_fence(GF_MAX_HOR_DIST=20.0, GF_MAX_VER_DIST=8.0)
    home = (100.0, 0.0, -1.0)
    assert fence.judge((115.0, -12.0, -8.9), home) is None
    assert fence.judge((116.1, -12.1, -5.0), home) == DISTANCE
    assert fence.judge((100.0, 0.0, -9.1), home) == ALTITUDE


def test_it_is_looked_at_five_times_a_second() -> None:
    fence = make_fence(GF_MAX_VER_DIST=8.0)
    assert fence.breach(0, HOME_NED, HOME_NED) is None
    assert fence.breach(196_000, (0.0, 0.0, -9.0), HOME_NED) is None
    assert fence.breach(200_000, (0.0, 0.0, -9.0), HOME_NED) == ALTITUDE


def fly_out(flight: Flight, action: int) -> float:
    """Fly north in OFFBOARD until something other than OFFBOARD flies; where it was noticed."""
    flight.parameters.set("GF_ACTION", action)
    flight.parameters.set("GF_MAX_HOR_DIST", 5.0)
    flight.place((0.0, 0.0, -6.0))
    flight.send(velocity_ned=(2.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
    flight.run_until(
        lambda: flight.autopilot.status.mode is not Mode.OFFBOARD or flight.time_us > 6e6,
        timeout_s=8.0,
    )
    return flight.estimate.position_ned[0]


@pytest.mark.parametrize(
    ("action", "mode"),
    [(2, Mode.HOLD), (3, Mode.RTL), (4, Mode.TERMINATION), (5, Mode.LAND)],
)
def test_leaving_the_fence(flight: Flight, action: int, mode: Mode) -> None:
    assert 5.0 <= fly_out(flight, action) < 5.0 + 2.2 * 0.2 + 0.1
    is_held_first = mode in (Mode.RTL, Mode.LAND)  # for COM_FAIL_ACT_T, as PX4 v1.17.0
    assert flight.said[:2] == [
        "2:Geofence violation: maximum distance to home exceeded",
        "2:Failsafe activated" + ": entering Hold for 5 seconds" * is_held_first,
    ]
    if is_held_first:
        flight.run(4.9)
        assert flight.autopilot.status.mode is Mode.HOLD
        flight.run(0.2)
    assert flight.autopilot.status.mode is mode
    assert flight.autopilot.status.failsafe or mode is Mode.TERMINATION


@pytest.mark.parametrize(("action", "texts"), [(0, 0), (1, 1)])
def test_fences_that_only_warn_or_not_even_that(flight: Flight, action: int, texts: int) -> None:
    fly_out(flight, action)
    assert flight.autopilot.status.mode is Mode.OFFBOARD
    assert len([line for line in flight.said if "Geofence" in line]) == texts


def test_the_pilot_may_take_over_outside(flight: Flight) -> None:
    fly_out(flight, 2)
    flight.run(4.0)
    assert flight.autopilot.status.mode is Mode.HOLD
    assert flight.command(20) == ACCEPTED  # home
    flight.run_until(lambda: flight.estimate.position_ned[0] < 3.0, timeout_s=30.0)
    assert flight.autopilot.status.mode is Mode.RTL
    assert not flight.autopilot.status.failsafe


def test_arming_outside_is_refused(flight: Flight) -> None:
    flight.run(1.1)
    elsewhere = (circle(CIRCLE_INCLUSION, 100.0, 0.0, 50.0),)
    result = flight.autopilot.missions.replace(PlanKind.FENCE, elsewhere, 0)
    assert result == MissionResult.ACCEPTED
    flight.run(0.3)
    assert flight.command(ARM, 1.0) == REJECTED
    flight.run(0.01)
    assert flight.said[-1] == "2:Arming denied: Resolve system health failures first"
    flight.autopilot.missions.replace(PlanKind.FENCE, (), 0)
    flight.run(0.3)
    assert flight.command(ARM, 1.0) == ACCEPTED


def test_nothing_leads_out_of_the_fence(flight: Flight) -> None:
    """Neither a goto, nor a mission, nor a new fence in flight that leaves the vehicle outside."""
    flight.place((0.0, 0.0, -6.0))
    flight.run(0.3)
    missions = flight.autopilot.missions
    area = polygon(POLYGON_INCLUSION, *SQUARE)
    assert missions.replace(PlanKind.FENCE, area, 0) == MissionResult.ACCEPTED
    far = place(WAYPOINT, 30.0, 0.0)
    to_it = (-1.0, 1.0, NAN, NAN, far.latitude_deg, far.longitude_deg, HOME[2] + 6.0)
    assert flight.command(REPOSITION, *to_it) == DENIED
    missions.replace(PlanKind.MISSION, (place(WAYPOINT, 1.0, 0.0), far), 0)
    assert flight.command(MISSION_START, 0.0) == DENIED
    elsewhere = (circle(CIRCLE_EXCLUSION, 0.0, 0.0, 5.0),)
    assert missions.replace(PlanKind.FENCE, elsewhere, 0) == MissionResult.DENIED
    assert missions.plan(PlanKind.FENCE) == area
    flight.run(0.01)
    assert flight.said == [
        "2:Reposition is outside geofence",
        "2:Geofence violation for waypoint 2",
        "2:Mission start denied! No valid mission",
        "2:Geofence invalid, doesn't contain current vehicle position",
    ]
