"""How far a real vehicle with PX4's simulated drag gets, by its ground truth, line by line.

PX4 was seen from hover, 4 s at 1 m/s (vertical 0.7), with SIH_KDV 1. Its least and greatest of each
move are widened by 15 %. Across it went up to 2.5 m with the errors of its estimate; half the
difference of opposite moves leaves those out.
"""

import math
import statistics
from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.lockstep_pilot import LOCAL_NED, Heard, LockstepPilot, Setpoint, named
from tests.wire.vehicle_process import Vehicle, is_acknowledgement

pytestmark = pytest.mark.flight
Vector3 = tuple[float, float, float]
WIDER = 0.15
TRUTH, SET_MESSAGE_INTERVAL = "HIL_STATE_QUATERNION", 511
TRUTH_US, TRUTH_HZ = 20_000, 50
MOVE_S, HEIGHT_M, EARTH_M_DEG = 4.0, 10.0, 111_195.0
MOVES = {  # velocity forward, right, down; m gone that way
    "forward": ((1.0, 0.0, 0.0), (2.4, 3.2)),
    "back": ((-1.0, 0.0, 0.0), (2.5, 3.0)),
    "right": ((0.0, 1.0, 0.0), (2.4, 3.2)),
    "left": ((0.0, -1.0, 0.0), (1.3, 2.7)),
    "down": ((0.0, 0.0, 0.7), (2.2, 2.8)),
    "up": ((0.0, 0.0, -0.7), (2.3, 2.8)),
}
OPPOSITES = (("forward", "back"), ("right", "left"))
ACROSS_M = 1.2
LAP_S = 13.0  # at some 0.48 rad/s
POSITION = 0xDF8  # position alone counts
NEAR_M, ARRIVAL_S, OFF_M = 0.3, (2.8, 4.6), 0.48
FASTEST_M_S = (9.6, 9.8)  # 6 s after 20 m/s was asked for; MPC_XY_VEL_MAX is 12


@pytest.fixture(scope="module")
def pilot() -> Iterator[LockstepPilot]:
    options = ("-q", "--lockstep", "--speed-factor=0", "--noise=0,0")
    with (
        Vehicle(*options, module="tests.wire.offboard.draggy_vehicle") as vehicle,
        LockstepPilot(vehicle) as pilot,
    ):
        pilot.gcs.command(
            SET_MESSAGE_INTERVAL, mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION, TRUTH_US
        )
        assert pilot.gcs.wait_for(is_acknowledgement(SET_MESSAGE_INTERVAL)).result == 0
        pilot.take_off_in_offboard(HEIGHT_M)
        yield pilot


@pytest.fixture(scope="module")
def moved(pilot: LockstepPilot) -> dict[str, Vector3]:
    """Metres forward, right, down that each move went, by the heading at its start."""
    gone = {}
    for name, (velocity, _) in MOVES.items():
        before = pilot.fly(1.0)
        during = pilot.fly(MOVE_S, Setpoint(velocity))
        assert len(named(during, TRUTH)) == pytest.approx(MOVE_S * TRUTH_HZ, abs=1)
        ends = zip(place_ned(before), place_ned(during), strict=True)
        north, east, down = (after - earlier for earlier, after in ends)
        yaw = named(before, "ATTITUDE")[-1].yaw
        cos, sin = math.cos(yaw), math.sin(yaw)
        gone[name] = (cos * north + sin * east, cos * east - sin * north, down)
        pilot.fly(2.0)
    return gone


def place_ned(heard: list[Heard]) -> Vector3:
    truth = named(heard, TRUTH)[-1]
    latitude, longitude = truth.lat / 1e7, truth.lon / 1e7
    east_m = longitude * EARTH_M_DEG * math.cos(math.radians(47.4))
    return latitude * EARTH_M_DEG, east_m, -truth.alt / 1e3


@pytest.mark.parametrize("name", MOVES)
def test_a_move_goes_as_far_as_px4s(moved: dict[str, Vector3], name: str) -> None:
    velocity, (low, high) = MOVES[name]
    speed = math.hypot(*velocity)
    along = sum(m * v / speed for m, v in zip(moved[name], velocity, strict=True))
    assert low * (1.0 - WIDER) <= along <= high * (1.0 + WIDER)


@pytest.mark.parametrize("names", OPPOSITES, ids="-".join)
def test_opposite_moves_go_straight(moved: dict[str, Vector3], names: tuple[str, str]) -> None:
    there, back = (moved[name] for name in names)
    across = 1 if names[0] == "forward" else 0
    assert abs(there[across] - back[across]) / 2.0 < ACROSS_M


def test_a_circle_is_as_wide_as_px4s(pilot: LockstepPilot) -> None:
    """PX4, 1 m/s ahead at 0.5 rad/s: radius 1.65 m, speed 0.72, body velocity 0.69, -0.17.

    These are of one circle by an estimate that is off by some 0.2 m/s, ours of one by the truth.
    """
    pilot.fly(4.0)
    heard = pilot.fly(16.0, Setpoint((1.0, 0.0, 0.0), yaw_rate=0.5))
    lap = [h for h in heard if h.time_s > heard[-1].time_s - LAP_S]
    truths = named(lap, TRUTH)
    body = [body_velocity(truth) for truth in truths]
    ahead, right = (statistics.mean(values) for values in zip(*body, strict=True))
    speed = statistics.mean(math.hypot(*velocity) for velocity in body)
    turn = statistics.mean(truth.yawspeed for truth in truths)
    assert speed == pytest.approx(0.72, rel=WIDER)
    assert speed / turn == pytest.approx(1.65, rel=WIDER)
    assert (ahead, right) == pytest.approx((0.69, -0.17), abs=0.15)


def body_velocity(truth: Any) -> tuple[float, float]:
    """Give m/s ahead and to the right, by the true heading."""
    w, x, y, z = truth.attitude_quaternion
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    north, east = truth.vx / 100.0, truth.vy / 100.0
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * north + sin * east, cos * east - sin * north


def test_a_place_is_reached_in_time(pilot: LockstepPilot) -> None:
    """PX4, 5 m away and 3 m up: within 0.3 m after 2.8 to 4.6 s, then off by 0.17 to 0.48 m."""
    here = named(pilot.fly(3.0), "LOCAL_POSITION_NED")[-1]
    there = (here.x + 5.0, here.y, here.z - 3.0)
    asked = Setpoint(frame=LOCAL_NED, mask=POSITION, position=there)
    begun_s = pilot.time_s
    arrived = pilot.fly_until(
        lambda m: m.get_type() == "LOCAL_POSITION_NED" and off_m(m, there) < NEAR_M, "place", asked
    )
    least, most = ARRIVAL_S
    assert least * (1.0 - WIDER) <= arrived.time_s - begun_s <= most * (1.0 + WIDER)
    after = named(pilot.fly(5.0, asked), "LOCAL_POSITION_NED")
    assert statistics.mean(off_m(place, there) for place in after) <= OFF_M * (1.0 + WIDER)


def off_m(place: Any, there: Vector3) -> float:
    return math.dist((place.x, place.y, place.z), there)


def test_more_speed_than_the_limit_ends_where_drag_and_limit_let_it(pilot: LockstepPilot) -> None:
    heard = pilot.fly(6.0, Setpoint((20.0, 0.0, 0.0)))
    last = named(heard, "LOCAL_POSITION_NED")[-1]
    asked = named(heard, "POSITION_TARGET_LOCAL_NED")[-1]
    low, high = FASTEST_M_S
    speed_m_s = math.hypot(last.vx, last.vy)
    assert low * (1.0 - WIDER) <= speed_m_s <= high * (1.0 + WIDER)
    assert math.hypot(asked.vx, asked.vy) <= 20.0
