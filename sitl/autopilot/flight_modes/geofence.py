"""The geofence: polygons and circles to stay within or out of, and limits around home.

All of them hold together, as in PX4: a place is inside if it is inside every inclusion, outside
every exclusion, and no further from home than GF_MAX_HOR_DIST and GF_MAX_VER_DIST allow.
"""

import math
from typing import NamedTuple, Self

from sitl.autopilot.flight_modes.mission_plan import (
    CIRCLE_INCLUSION,
    CIRCLES,
    POLYGON_INCLUSION,
    POLYGONS,
)
from sitl.autopilot.parameters import ParameterValues
from sitl.frames import ned_from_geodetic
from sitl.records.missions import MissionItem, Plan
from sitl.records.motion import Vector3

CHECK_INTERVAL_US = 200_000  # as often as PX4 looks
DISTANCE = "maximum distance to home exceeded"
ALTITUDE = "maximum altitude above home exceeded"
AREA = "outside the permitted area"


class Area(NamedTuple):
    """A polygon, or a circle where there is a radius; local, north and east in m."""

    is_inclusion: bool
    points: tuple[tuple[float, float], ...]
    radius_m: float = 0.0

    def permits(self, north: float, east: float) -> bool:
        """Whether a place is on the right side."""
        if self.radius_m > 0.0:
            x, y = self.points[0]
            inside = math.hypot(north - x, east - y) < self.radius_m
        else:
            inside = _is_in_polygon(self.points, north, east)
        return inside is self.is_inclusion


class FenceParameters(NamedTuple):
    """Limits around home, and what leaving them does."""

    distance_max_m: float  # GF_MAX_HOR_DIST; not above 0: none
    height_max_m: float  # GF_MAX_VER_DIST; likewise
    acts: bool  # GF_ACTION: something is done about a breach

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(
            distance_max_m=values["GF_MAX_HOR_DIST"],
            height_max_m=values["GF_MAX_VER_DIST"],
            acts=int(values["GF_ACTION"]) > 0,
        )


class FenceCheck(NamedTuple):
    """What was wrong where the vehicle was."""

    time_us: int
    breach: str | None = None


NEVER_CHECKED = FenceCheck(-CHECK_INTERVAL_US)


class Geofence:
    """Says what is wrong with a place."""

    def __init__(self, parameters: FenceParameters, origin: Vector3) -> None:
        self.parameters = parameters
        self._origin = origin  # latitude deg, longitude deg, altitude m of the local frame
        self._areas: tuple[Area, ...] = ()
        self._last = NEVER_CHECKED

    def take(self, plan: Plan) -> None:
        """Replace the polygons and circles."""
        self._areas = areas_of(plan, self._origin)
        self._last = self._last._replace(time_us=NEVER_CHECKED.time_us)

    def breach(self, time_us: int, position_ned: Vector3, home_ned: Vector3) -> str | None:
        """Say what is wrong where the vehicle is, five times a second."""
        if time_us - self._last.time_us >= CHECK_INTERVAL_US:
            self._last = FenceCheck(time_us, self.judge(position_ned, home_ned))
        return self._last.breach

    def judge(self, position_ned: Vector3, home_ned: Vector3) -> str | None:
        """Say what is wrong with a place; None if nothing is. NaN counts as where home is."""
        north, east, down = (
            h if math.isnan(p) else p for p, h in zip(position_ned, home_ned, strict=True)
        )
        distance = math.hypot(north - home_ned[0], east - home_ned[1])
        if 0.0 < self.parameters.distance_max_m <= distance:
            return DISTANCE
        if 0.0 < self.parameters.height_max_m <= home_ned[2] - down:
            return ALTITUDE
        permitted = all(area.permits(north, east) for area in self._areas)
        return None if permitted else AREA


def areas_of(plan: Plan, origin: Vector3) -> tuple[Area, ...]:
    """Turn a checked plan into areas; return points are kept, but nothing leads to them."""
    areas = []
    index = 0
    while index < len(plan):
        item = plan[index]
        if item.command in CIRCLES:
            inclusion = item.command == CIRCLE_INCLUSION
            areas.append(Area(inclusion, (_point(item, origin),), item.params[0]))
        elif item.command in POLYGONS:
            vertices = plan[index : index + int(item.params[0])]
            points = tuple(_point(vertex, origin) for vertex in vertices)
            areas.append(Area(item.command == POLYGON_INCLUSION, points))
            index += len(vertices) - 1
        index += 1
    return tuple(areas)


def _point(item: MissionItem, origin: Vector3) -> tuple[float, float]:
    north, east, _ = ned_from_geodetic((item.latitude_deg, item.longitude_deg, 0.0), origin)
    return (north, east)


def _is_in_polygon(points: tuple[tuple[float, float], ...], north: float, east: float) -> bool:
    """Count the edges that a line due south from the place crosses: odd within."""
    inside = False
    x0, y0 = points[-1]
    for x1, y1 in points:
        if (y1 >= east) is not (y0 >= east) and north <= (x0 - x1) * (east - y1) / (y0 - y1) + x1:
            inside = not inside
        x0, y0 = x1, y1
    return inside
