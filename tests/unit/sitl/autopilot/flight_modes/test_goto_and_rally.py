"""Going to a place by command, and returning to the one that RTL_TYPE asks for."""

import math

import pytest

from sitl.frames import geodetic_from_ned, yaw_of
from sitl.records.missions import PlanKind
from tests.unit.sitl.autopilot.conftest import HOME, NAN, Flight
from tests.unit.sitl.autopilot.flight_modes.made_plans import RALLY_POINT, place
from tests.unit.sitl.autopilot.flight_modes.mission_run import MissionRun

GO_HOME, REPOSITION = 20, 192
ACCEPTED, DENIED = 0, 2


@pytest.fixture
def run(flight: Flight) -> MissionRun:
    return MissionRun(flight)


@pytest.mark.parametrize(
    ("rtl_type", "rally", "north_m"),
    [(0, 30.0, 30.0), (0, -40.0, 0.0), (1, -40.0, -40.0), (2, 30.0, 0.0)],
)
def test_a_return_leads_to_the_place_that_rtl_type_asks_for(
    run: MissionRun, rtl_type: int, rally: float, north_m: float
) -> None:
    run.flight.parameters.set("RTL_TYPE", rtl_type)
    run.in_air()
    run.flight.place((20.0, 0.0, -6.0))
    run.missions.replace(PlanKind.RALLY, (place(RALLY_POINT, rally, 0.0, 0.0),), 0)
    assert run.flight.command(GO_HOME) == ACCEPTED
    run.flight.run(16.0)
    way_m = run.flight.estimate.position_ned[0] - 20.0
    assert way_m * (north_m - 20.0) > 0.0
    assert abs(way_m) > 3.0


@pytest.mark.parametrize(
    ("altitude_m", "frame", "height_m"),
    [(HOME[2] + 9.0, 0, 9.0), (9.0, 6, 9.0), (NAN, 6, 6.0)],
)
def test_goto(run: MissionRun, altitude_m: float, frame: int, height_m: float) -> None:
    run.in_air()
    latitude, longitude, _ = geodetic_from_ned((4.0, 3.0, 0.0), HOME)
    params = (-1.0, 1.0, NAN, math.radians(-90.0), latitude, longitude, altitude_m)
    assert run.flight.command(REPOSITION, *params, frame=frame) == ACCEPTED
    run.flight.run(8.0)
    assert math.dist(run.flight.estimate.position_ned, (4.0, 3.0, -height_m)) < 0.2
    assert yaw_of(run.flight.estimate.q_ned_frd) == pytest.approx(-math.pi / 2, abs=0.05)


@pytest.mark.parametrize(
    ("latitude", "longitude", "flags", "result"),
    [
        (NAN, NAN, 1.0, ACCEPTED),
        (47.4, NAN, 1.0, ACCEPTED),  # half a place is none
        (NAN, 8.5, 1.0, ACCEPTED),
        (91.0, 8.5, 1.0, DENIED),
        (47.4, -181.0, 1.0, DENIED),
        (47.4, 8.5, 0.0, 3),
    ],
)
def test_places_that_cannot_be_gone_to(
    run: MissionRun, latitude: float, longitude: float, flags: float, result: int
) -> None:
    run.in_air()
    params = (-1.0, flags, NAN, NAN, latitude, longitude, NAN)
    assert run.flight.command(REPOSITION, *params) == result
    run.flight.run(1.0)
    assert math.dist(run.flight.estimate.position_ned, (0.0, 0.0, -6.0)) < 0.2
