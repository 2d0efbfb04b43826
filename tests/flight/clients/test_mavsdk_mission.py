"""MAVSDK, written by others, uploads missions and fences, flies a square and comes home."""

import math
from collections.abc import Iterable
from pathlib import Path

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action, ActionError
from mavsdk.plugins.geofence import Circle, FenceType, Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.mission import Mission, MissionItem, MissionPlan
from mavsdk.plugins.mission_raw import MissionItem as RawItem
from mavsdk.plugins.mission_raw import MissionRaw, MissionRawError
from mavsdk.plugins.telemetry import FlightMode, Telemetry

from tests.flight.clients.mavsdk_vehicle import Latest, Motion, Track, found_vehicle
from tests.flight.tlogs import of_type, read

pytestmark = pytest.mark.flight
HOME = (47.397742, 8.545594, 489.4)
EARTH_RADIUS_M = 6371000.0
LEG_M = HEIGHT_M = 6.0
ACCEPTANCE_M = 1.0
SQUARE = ((LEG_M, 0.0), (LEG_M, LEG_M), (0.0, LEG_M), (0.0, 0.0))
NAN = math.nan
GLOBAL_RELATIVE, MISSION_FRAME = 6, 2
WAYPOINT, RALLY_POINT, UNHEARD_OF = 16, 5100, 9999
SET_MODE, ARMED = 176, 128
RTL_MODE = 0x05040000
FAST = "--speed-factor=10"  # nobody streams here
# A real PX4 with its simulator's drag was seen to fly the square in 27 to 29 s, and to be disarmed
# 20 s after that.
MISSION_S, RETURN_S, WIDER = (27.0, 29.0), (20.0, 20.0), 0.15


def degrees(north_m: float, east_m: float) -> tuple[float, float]:
    """Latitude and longitude of a place near home."""
    around_m = EARTH_RADIUS_M * math.cos(math.radians(HOME[0]))
    return (
        HOME[0] + math.degrees(north_m / EARTH_RADIUS_M),
        HOME[1] + math.degrees(east_m / around_m),
    )


def waypoint(north_m: float, east_m: float) -> MissionItem:
    return MissionItem(
        *degrees(north_m, east_m),
        relative_altitude_m=HEIGHT_M,
        speed_m_s=5.0,
        is_fly_through=False,
        gimbal_pitch_deg=NAN,
        gimbal_yaw_deg=NAN,
        camera_action=MissionItem.CameraAction.NONE,
        loiter_time_s=NAN,
        camera_photo_interval_s=NAN,
        acceptance_radius_m=ACCEPTANCE_M,
        yaw_deg=NAN,
        camera_photo_distance_m=NAN,
        vehicle_action=MissionItem.VehicleAction.NONE,
    )


def raw(sequence: int, command: int, *, frame: int = GLOBAL_RELATIVE, kind: int = 0) -> RawItem:
    latitude, longitude = degrees(3.0 * sequence, 0.0)
    place = (round(latitude * 1e7), round(longitude * 1e7), 6.0)
    return RawItem(
        sequence, frame, command, int(sequence == 0), 1, 0.0, NAN, 0.0, NAN, *place, kind
    )


def test_a_square_mission_and_home_again(tmp_path: Path) -> None:
    log = tmp_path / "vehicle.tlog"
    vehicle = found_vehicle(
        tmp_path, FAST, f"--log={log}", module="tests.wire.offboard.draggy_vehicle"
    )
    with vehicle as system:
        fly_mission(system)
    messages = read(log)
    begun_s = [m._timestamp for m in of_type(messages, "COMMAND_LONG") if m.command == SET_MODE][-1]
    done_s = [m._timestamp for m in of_type(messages, "MISSION_ITEM_REACHED")][-1]
    beats = [m for m in of_type(messages, "HEARTBEAT") if m.get_srcComponent() == 1]
    returning = [m._timestamp for m in beats if m.custom_mode == RTL_MODE and m.base_mode & ARMED]
    for took_s, (low, high) in (
        (done_s - begun_s, MISSION_S),
        (returning[-1] - done_s, RETURN_S),  # and a second at most until the next beat
    ):
        assert low * (1.0 - WIDER) <= took_s <= high * (1.0 + WIDER)


def fly_mission(system: System) -> None:
    telemetry, action, mission = Telemetry(system), Action(system), Mission(system)
    plan = MissionPlan([waypoint(*corner) for corner in SQUARE])
    Latest(telemetry.subscribe_health_all_ok).until(bool, "healthy", timeout_s=20.0)

    mission.set_return_to_launch_after_mission(enable=True)
    mission.upload_mission(plan)
    kept = mission.download_mission().mission_items
    assert len(kept) == len(SQUARE)
    for item, (north_m, east_m) in zip(kept, SQUARE, strict=True):
        here = degrees(north_m, east_m)
        assert (item.latitude_deg, item.longitude_deg) == pytest.approx(here, abs=1e-7)
        assert (item.relative_altitude_m, item.speed_m_s) == (HEIGHT_M, 5.0)

    modes = Latest(telemetry.subscribe_flight_mode)
    track = Track(telemetry)
    progress = Latest(mission.subscribe_mission_progress)
    armed = Latest(telemetry.subscribe_armed)
    action.arm()
    mission.start_mission()
    modes.until(lambda mode: mode == FlightMode.MISSION, "mission", timeout_s=5.0)
    modes.until(lambda mode: mode == FlightMode.RETURN_TO_LAUNCH, "return", timeout_s=60.0)
    assert mission.is_mission_finished()
    passed = [(value.current, value.total) for value in progress.drain()]
    assert [current for current, _ in dict.fromkeys(passed)] == [0, 1, 2, 3, 4]
    assert {total for _, total in passed} == {len(SQUARE)}
    check_path(track.drain())

    armed.until(bool, "armed", timeout_s=1.0)
    armed.until(lambda value: not value, "landed and disarmed", timeout_s=60.0)
    end = track.now().place_ned
    assert math.hypot(end[0], end[1]) < 2.0


def check_path(motions: Iterable[Motion]) -> None:
    """Every corner was passed, at the mission's height, and nothing outside of the square."""
    places = [motion.place_ned for motion in motions]
    for north_m, east_m in SQUARE:
        nearest = min(places, key=lambda place: math.dist(place[:2], (north_m, east_m)))
        assert math.dist(nearest[:2], (north_m, east_m)) < ACCEPTANCE_M + 0.5
    assert all(-2.0 < number < LEG_M + 2.0 for place in places for number in place[:2])
    assert max(-place[2] for place in places) < HEIGHT_M + 1.0


def test_a_geofence_and_what_it_forbids(system: System) -> None:
    geofence, action = Geofence(system), Action(system)
    corners = [Point(*degrees(n, e)) for n, e in ((30, 30), (30, -30), (-30, -30), (-30, 30))]
    hut = Circle(Point(*degrees(15.0, 0.0)), 4.0, FenceType.EXCLUSION)
    data = GeofenceData([Polygon(corners, FenceType.INCLUSION)], [hut])
    geofence.upload_geofence(data)
    kept = geofence.download_geofence()
    assert [len(polygon.points) for polygon in kept.polygons] == [4]
    assert kept.polygons[0].fence_type == FenceType.INCLUSION
    assert kept.polygons[0].points[1].latitude_deg == pytest.approx(corners[1].latitude_deg)
    assert [(circle.radius, circle.fence_type) for circle in kept.circles] == [
        (4.0, FenceType.EXCLUSION)
    ]

    telemetry = Telemetry(system)
    Latest(telemetry.subscribe_health_all_ok).until(bool, "healthy", timeout_s=20.0)
    modes = Latest(telemetry.subscribe_flight_mode)
    action.arm()
    action.takeoff()
    modes.until(lambda mode: mode == FlightMode.TAKEOFF, "take-off", timeout_s=5.0)
    modes.until(lambda mode: mode == FlightMode.HOLD, "hold", timeout_s=10.0)
    altitude_m = HOME[2] + 4.0
    with pytest.raises(ActionError):
        action.goto_location(*degrees(15.0, 1.0), altitude_m, NAN)
    action.goto_location(*degrees(5.0, 0.0), altitude_m, NAN)
    track = Track(telemetry)
    there = track.until(lambda m: abs(m.place_ned[0] - 5.0) < 0.5, "the place", within_s=20.0)
    assert abs(there.place_ned[1]) < 1.0
    action.hold()
    assert max(abs(m.place_ned[0] - 5.0) for m in track.wait(2.0)) < 1.5
    geofence.clear_geofence()
    assert geofence.download_geofence().polygons == []


def test_rally_points_and_items_that_cannot_be_flown(system: System) -> None:
    missions = MissionRaw(system)
    rally = [raw(n, RALLY_POINT, kind=2) for n in range(3)]
    missions.upload_rally_points(rally)
    assert [point.x for point in missions.download_rallypoints()] == [point.x for point in rally]

    missions.upload_mission([raw(0, WAYPOINT), raw(1, WAYPOINT)])
    with pytest.raises(MissionRawError):
        missions.upload_mission([raw(0, WAYPOINT), raw(1, UNHEARD_OF)])
    with pytest.raises(MissionRawError):
        missions.upload_mission([raw(0, WAYPOINT, frame=1)])
    kept = missions.download_mission()
    assert [(item.command, item.frame, item.current) for item in kept] == [
        (WAYPOINT, GLOBAL_RELATIVE, 1),
        (WAYPOINT, GLOBAL_RELATIVE, 0),
    ]
    assert all(math.isnan(item.param4) for item in kept)
    missions.set_current_mission_item(1)
    assert missions.download_mission()[1].current == 1
    missions.clear_mission()
    assert missions.download_mission() == []
