"""Where a return leads: home, or the nearest rally point, as RTL_TYPE asks."""

import math

from sitl.autopilot.flight_modes.mission_plan import RELATIVE_FRAMES
from sitl.frames import ned_from_geodetic
from sitl.records.missions import Plan
from sitl.records.motion import Vector3

HOME_OR_RALLY = {0, 3, 5}  # RTL_TYPE: whatever is nearest
RALLY_FIRST = 1  # home only where there is no rally point; the other types follow the mission


def destination(
    position_ned: Vector3, home_ned: Vector3, rally_ned: tuple[Vector3, ...], rtl_type: int
) -> Vector3:
    """Choose where to return to, local NED."""
    places: tuple[Vector3, ...] = (home_ned,)
    if rtl_type in HOME_OR_RALLY:
        places = (home_ned, *rally_ned)
    elif rtl_type == RALLY_FIRST:
        places = rally_ned or places
    x, y, _ = position_ned
    return min(places, key=lambda place: math.hypot(place[0] - x, place[1] - y))


def places_of(plan: Plan, origin: Vector3, home_ned: Vector3) -> tuple[Vector3, ...]:
    """Local places of rally points."""
    places = []
    for item in plan:
        x, y, z = ned_from_geodetic((item.latitude_deg, item.longitude_deg, item.z), origin)
        places.append((x, y, home_ned[2] - item.z if item.frame in RELATIVE_FRAMES else z))
    return tuple(places)
