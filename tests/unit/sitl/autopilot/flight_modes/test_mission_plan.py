"""Which items and plans are taken, and which number is to blame if not."""

import math
from dataclasses import replace

import pytest

from sitl.autopilot.flight_modes.mission_plan import check_item, check_plan
from sitl.records.mavlink_numbers import NOT_GIVEN
from sitl.records.missions import MissionItem, MissionResult, PlanKind
from tests.unit.sitl.autopilot.flight_modes.made_plans import (
    CIRCLE_EXCLUSION,
    CIRCLE_INCLUSION,
    DELAY,
    JUMP,
    LAND,
    LOITER_TIME,
    POLYGON_EXCLUSION,
    POLYGON_INCLUSION,
    RALLY_POINT,
    REGION_OF_INTEREST,
    RETURN,
    SPEED,
    TAKEOFF,
    WAYPOINT,
    circle,
    deed,
    place,
    polygon,
)

R = MissionResult
MISSION, FENCE, RALLY = PlanKind
SQUARE = ((10.0, 10.0), (10.0, -10.0), (-10.0, -10.0), (-10.0, 10.0))
WAY = place(WAYPOINT, 6.0, 0.0, 6.0, 0.0, 2.0)


@pytest.mark.parametrize(
    ("kind", "item", "result"),
    [
        (MISSION, WAY, R.ACCEPTED),
        (MISSION, replace(WAY, params=(math.nan,) * 4), R.ACCEPTED),
        (MISSION, replace(WAY, command=9999), R.UNSUPPORTED),
        (MISSION, replace(WAY, command=RALLY_POINT), R.UNSUPPORTED),
        (RALLY, WAY, R.UNSUPPORTED),
        (FENCE, WAY, R.UNSUPPORTED),
        (MISSION, replace(WAY, frame=1), R.UNSUPPORTED_FRAME),
        (MISSION, replace(WAY, frame=10), R.UNSUPPORTED_FRAME),
        (MISSION, replace(WAY, x=900000001), R.INVALID_PARAM5_X),
        (MISSION, replace(WAY, y=-1800000001), R.INVALID_PARAM6_Y),
        (MISSION, replace(WAY, x=NOT_GIVEN), R.INVALID_PARAM5_X),
        (MISSION, replace(WAY, z=math.nan), R.INVALID_PARAM7),
        (MISSION, replace(WAY, z=1e6), R.INVALID_PARAM7),
        (MISSION, replace(WAY, params=(1e9, 2.0, 0.0, 0.0)), R.INVALID_PARAM1),
        (MISSION, replace(WAY, params=(0.0, -1e9, 0.0, 0.0)), R.INVALID_PARAM2),
        (MISSION, replace(WAY, command=LAND, x=NOT_GIVEN, y=NOT_GIVEN), R.ACCEPTED),
        (MISSION, replace(WAY, command=TAKEOFF, x=NOT_GIVEN, y=NOT_GIVEN), R.ACCEPTED),
        (MISSION, place(LOITER_TIME, 0.0, 0.0, 6.0, 5.0), R.ACCEPTED),
        (MISSION, deed(RETURN), R.ACCEPTED),
        (MISSION, deed(REGION_OF_INTEREST, 3.0), R.ACCEPTED),
        (MISSION, deed(JUMP, 0.0, 3.0), R.ACCEPTED),
        (MISSION, deed(JUMP, 0.5, 3.0), R.INVALID_PARAM1),
        (MISSION, deed(JUMP, 0.0, math.nan), R.INVALID_PARAM2),
        (MISSION, deed(JUMP, 0.0, 1e9), R.INVALID_PARAM2),
        (MISSION, deed(DELAY, 2.5), R.ACCEPTED),
        (MISSION, deed(DELAY, -1.0), R.INVALID_PARAM1),
        (MISSION, deed(SPEED, 1.0, 3.0), R.ACCEPTED),
        (MISSION, deed(SPEED, 1.0, math.nan), R.INVALID_PARAM2),
        (FENCE, circle(CIRCLE_INCLUSION, 0.0, 0.0, 50.0), R.ACCEPTED),
        (FENCE, circle(CIRCLE_EXCLUSION, 0.0, 0.0, 0.0), R.INVALID_PARAM1),
        (FENCE, circle(CIRCLE_INCLUSION, 0.0, 0.0, math.nan), R.INVALID_PARAM1),
        (FENCE, polygon(POLYGON_INCLUSION, *SQUARE)[0], R.ACCEPTED),
        (FENCE, polygon(POLYGON_INCLUSION, *SQUARE[:2])[0], R.INVALID_PARAM1),
        (FENCE, place(POLYGON_INCLUSION, 0.0, 0.0, 0.0, 3.5), R.INVALID_PARAM1),
        (RALLY, place(RALLY_POINT, 30.0, 0.0), R.ACCEPTED),
        (RALLY, place(RALLY_POINT, 30.0, 0.0, math.nan), R.INVALID_PARAM7),
    ],
)
def test_items(kind: PlanKind, item: MissionItem, result: MissionResult) -> None:
    assert check_item(kind, item) == result


@pytest.mark.parametrize(
    ("kind", "plan", "result"),
    [
        (MISSION, (), R.ACCEPTED),
        (MISSION, (WAY, deed(JUMP, 0.0, 2.0)), R.ACCEPTED),
        (MISSION, (WAY, deed(JUMP, 2.0, 2.0)), R.INVALID_PARAM1),
        (MISSION, (WAY, deed(JUMP, -1.0, 2.0)), R.INVALID_PARAM1),
        (FENCE, polygon(POLYGON_INCLUSION, *SQUARE), R.ACCEPTED),
        (FENCE, polygon(POLYGON_INCLUSION, *SQUARE) * 2, R.ACCEPTED),
        (FENCE, polygon(POLYGON_INCLUSION, *SQUARE)[:3], R.INVALID),
        (
            FENCE,
            polygon(POLYGON_INCLUSION, *SQUARE)[:2] + polygon(POLYGON_EXCLUSION, *SQUARE)[:2],
            R.INVALID,
        ),
        (RALLY, (place(RALLY_POINT, 30.0, 0.0),), R.ACCEPTED),
    ],
)
def test_plans(kind: PlanKind, plan: tuple[MissionItem, ...], result: MissionResult) -> None:
    assert check_plan(kind, plan) == result
