"""Plans around home, written in metres."""

import math

from sitl.frames import geodetic_from_ned
from sitl.records.missions import MissionItem
from tests.unit.sitl.autopilot.conftest import HOME

NAN = math.nan
RELATIVE, ABSOLUTE, MISSION = 6, 5, 2  # MAV_FRAME
WAYPOINT, LOITER_UNLIMITED, LOITER_TIME, RETURN, LAND, TAKEOFF = 16, 17, 19, 20, 21, 22
LOITER_TO_ALTITUDE, DELAY, JUMP, SPEED, REGION_OF_INTEREST = 31, 93, 177, 178, 201
POLYGON_INCLUSION, POLYGON_EXCLUSION, CIRCLE_INCLUSION, CIRCLE_EXCLUSION = 5001, 5002, 5003, 5004
RALLY_POINT = 5100


def place(
    command: int, north_m: float, east_m: float, height_m: float = 6.0, *params: float
) -> MissionItem:
    """An item at a place, its height above home; params are the first ones, the rest NaN."""
    latitude, longitude, _ = geodetic_from_ned((north_m, east_m, 0.0), HOME)
    a, b, c, d = (*params, *[NAN] * (4 - len(params)))
    return MissionItem(
        command=command,
        frame=RELATIVE,
        params=(a, b, c, d),
        x=round(latitude * 1e7),
        y=round(longitude * 1e7),
        z=height_m,
    )


def deed(command: int, *params: float) -> MissionItem:
    """An item without a place."""
    a, b, c, d = (*params, *[NAN] * (4 - len(params)))
    return MissionItem(command=command, frame=MISSION, params=(a, b, c, d), x=0, y=0, z=0.0)


def polygon(command: int, *corners: tuple[float, float]) -> tuple[MissionItem, ...]:
    return tuple(place(command, north, east, 0.0, len(corners)) for north, east in corners)


def circle(command: int, north_m: float, east_m: float, radius_m: float) -> MissionItem:
    return place(command, north_m, east_m, 0.0, radius_m)
