"""What the items of a plan mean: which can be flown, by which numbers, and how fast."""

from math import isfinite, isnan, nan

from sitl.records.missions import MissionItem, MissionResult, Plan, PlanKind

# MAV_CMD
WAYPOINT, LOITER_UNLIMITED, LOITER_TIME = 16, 17, 19
RETURN_TO_LAUNCH, LAND, TAKEOFF = 20, 21, 22
LOITER_TO_ALTITUDE, DELAY = 31, 93
DO_JUMP, DO_CHANGE_SPEED = 177, 178
# What PX4 takes and this vehicle has nothing for: home, land start, regions of interest, gimbals,
# cameras, lights, grippers.
IGNORED = {
    *(179, 183, 187, 189, 195, 196, 197, 200, 201, 203, 204, 205, 206, 211, 214),
    *(530, 531, 532, 1000, 1001, 2000, 2001, 2003, 2500, 2501),
}
FENCE_RETURN_POINT = 5000
POLYGON_INCLUSION, POLYGON_EXCLUSION = 5001, 5002
CIRCLE_INCLUSION, CIRCLE_EXCLUSION = 5003, 5004
RALLY_POINT = 5100

POLYGONS = {POLYGON_INCLUSION, POLYGON_EXCLUSION}
CIRCLES = {CIRCLE_INCLUSION, CIRCLE_EXCLUSION}
PLACES = {WAYPOINT, LOITER_UNLIMITED, LOITER_TIME, LAND, TAKEOFF, LOITER_TO_ALTITUDE}
WAITS = {WAYPOINT, LOITER_TIME, DELAY}  # param1: how long, s
PLACE_OPTIONAL = {LAND, TAKEOFF}  # may begin or end where the vehicle is
FLOWN = PLACES | {RETURN_TO_LAUNCH, DELAY, DO_JUMP, DO_CHANGE_SPEED} | IGNORED
COMMANDS = {
    PlanKind.MISSION: FLOWN,
    PlanKind.FENCE: POLYGONS | CIRCLES | {FENCE_RETURN_POINT},
    PlanKind.RALLY: {RALLY_POINT},
}

ABSOLUTE_FRAMES, RELATIVE_FRAMES = {0, 5}, {3, 6}  # MAV_FRAME, of altitudes
ALTITUDE_MAX_M = 1e5
RADIUS_MAX_M = 1e6
SECONDS_MAX = 1e6
LATITUDE_MAX_DEG, LONGITUDE_MAX_DEG = 90.0, 180.0
VERTICES_MIN = 3
SPEED_RESET = -2.0  # DO_CHANGE_SPEED.param2

ACCEPTED = MissionResult.ACCEPTED


def check_item(kind: PlanKind, item: MissionItem) -> MissionResult:
    """Say whether an item can be part of a plan, or which of its numbers cannot be."""
    if item.command not in COMMANDS[kind]:
        return MissionResult.UNSUPPORTED
    if kind is PlanKind.MISSION and item.command not in PLACES:
        return _check_immediate(item)
    if item.frame not in ABSOLUTE_FRAMES | RELATIVE_FRAMES:
        return MissionResult.UNSUPPORTED_FRAME
    place = _check_place(item)
    if place is not ACCEPTED or kind is PlanKind.RALLY:
        return place
    return _check_fence(item) if kind is PlanKind.FENCE else _check_waits(item)


def check_plan(kind: PlanKind, plan: Plan) -> MissionResult:
    """Say whether the items make a whole: jumps lead into it, polygons are complete."""
    if kind is PlanKind.MISSION:
        jumps = (item.params[0] for item in plan if item.command == DO_JUMP)
        inside = all(0 <= target < len(plan) for target in jumps)
        return ACCEPTED if inside else MissionResult.INVALID_PARAM1
    if kind is PlanKind.FENCE:
        return ACCEPTED if _polygons_are_whole(plan) else MissionResult.INVALID
    return ACCEPTED


def speed_before(plan: Plan, index: int) -> float:
    """Speed that a plan has changed to before an item, m/s; NaN: the usual one."""
    speed_m_s = nan
    for item in plan[:index]:
        if item.command == DO_CHANGE_SPEED:
            speed_m_s = speed_of(item, speed_m_s)
    return speed_m_s


def speed_of(item: MissionItem, present_m_s: float) -> float:
    """Speed after a DO_CHANGE_SPEED; what is not positive leaves it, -2 resets it."""
    wanted = item.params[1]
    if wanted == SPEED_RESET:
        return nan
    return wanted if wanted > 0.0 else present_m_s


def _check_place(item: MissionItem) -> MissionResult:
    latitude, longitude = item.latitude_deg, item.longitude_deg
    open_place = item.command in PLACE_OPTIONAL and isnan(latitude) and isnan(longitude)
    if not (abs(latitude) <= LATITUDE_MAX_DEG or open_place):
        return MissionResult.INVALID_PARAM5_X
    if not (abs(longitude) <= LONGITUDE_MAX_DEG or open_place):
        return MissionResult.INVALID_PARAM6_Y
    return ACCEPTED if abs(item.z) <= ALTITUDE_MAX_M else MissionResult.INVALID_PARAM7


def _check_waits(item: MissionItem) -> MissionResult:
    """Hold time and acceptance radius: NaN stands for the default."""
    for number, limit in ((0, SECONDS_MAX), (1, RADIUS_MAX_M)):
        if abs(item.params[number]) > limit:
            return MissionResult(MissionResult.INVALID_PARAM1 + number)
    return ACCEPTED


def _check_immediate(item: MissionItem) -> MissionResult:
    first, second = item.params[:2]
    if item.command == DO_JUMP:
        if not (isfinite(first) and first == int(first)):
            return MissionResult.INVALID_PARAM1
        return ACCEPTED if -1 <= second <= 0xFFFF else MissionResult.INVALID_PARAM2
    if item.command == DELAY:
        return ACCEPTED if 0 <= first <= SECONDS_MAX else MissionResult.INVALID_PARAM1
    if item.command == DO_CHANGE_SPEED and isnan(second):
        return MissionResult.INVALID_PARAM2
    return ACCEPTED


def _check_fence(item: MissionItem) -> MissionResult:
    size = item.params[0]
    if item.command in CIRCLES:
        return ACCEPTED if 0 < size <= RADIUS_MAX_M else MissionResult.INVALID_PARAM1
    if item.command in POLYGONS:
        whole = isfinite(size) and size == int(size) and size >= VERTICES_MIN
        return ACCEPTED if whole else MissionResult.INVALID_PARAM1
    return ACCEPTED


def _polygons_are_whole(plan: Plan) -> bool:
    """Whether each polygon has as many vertices, one after another, as it says."""
    index = 0
    while index < len(plan):
        first = plan[index]
        if first.command not in POLYGONS:
            index += 1
            continue
        vertices = plan[index : index + int(first.params[0])]
        alike = all((v.command, v.params[0]) == (first.command, first.params[0]) for v in vertices)
        if len(vertices) < first.params[0] or not alike:
            return False
        index += len(vertices)
    return True
