"""What a real PX4 was seen doing in OFFBOARD, line by line, from one running vehicle in the air.

Without sticks v1.17.0 takes NAV_RCL_ACT where COM_OBL_RC_ACT is a pilot's mode; an older main, of
which the bands are, went to Position all the same, and came down.

The vehicle flies in lockstep, so the times are the vehicle's and the same on any host. Telemetry
comes at 50 Hz and HEARTBEAT at 1 Hz: what is read off them may be that much late.
"""

import itertools
import math
import struct
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.lockstep_pilot import (
    ACTIVE,
    BEAT_S,
    HOME_AMSL_M,
    IMAGE_S,
    LOCAL_NED,
    SET_MODE,
    SILENCE,
    STILL,
    Heard,
    LockstepPilot,
    Setpoint,
    named,
)
from tests.wire.vehicle_process import Vehicle, is_from, is_text

pytestmark = pytest.mark.flight
NAN = math.nan
OFFBOARD = 0x00060000
HOLD, RTL, LAND = 0x03040000, 0x05040000, 0x06040000
CRITICAL = 5
READ_S = 0.02  # between two ATTITUDEs
HEIGHT_M = 10.0
VELOCITY_AND_YAW = 0x9C7  # instead of the yaw rate
VELOCITY_AND_HEIGHT = 0x5E3  # x, y and vz ignored
FORWARD = Setpoint((1.0, 0.0, 0.0))
TURN = math.radians(95.0)  # 94 to 96 deg after 4 s at 0.5 rad/s
LOST_S = (0.98, 1.09)  # after the last setpoint


@pytest.fixture(scope="module")
def flying() -> Iterator[LockstepPilot]:
    options = ("-q", "--lockstep", "--speed-factor=0", "--noise=0,0")
    with Vehicle(*options) as vehicle, LockstepPilot(vehicle) as pilot:
        pilot.take_off_in_offboard(HEIGHT_M)
        yield pilot


@pytest.fixture
def pilot(flying: LockstepPilot) -> LockstepPilot:
    """Hand out the vehicle in a hover at 10 m, in OFFBOARD, facing north."""
    flying.enter_offboard()
    height = Setpoint(frame=LOCAL_NED, mask=0x9E3, position=(0.0, 0.0, -HEIGHT_M))
    flying.fly_until(
        lambda m: m.get_type() == "LOCAL_POSITION_NED" and abs(m.z + HEIGHT_M) < 0.5,
        "height",
        height,
    )
    flying.fly_until(lambda m: m.get_type() == "ATTITUDE" and abs(m.yaw) < 0.05, "north", height)
    flying.fly(2.0, height)
    return flying


def last(heard: list[Heard], name: str) -> Any:
    return named(heard, name)[-1]


def speeds_along(heard: list[Heard]) -> tuple[float, float]:
    """Speed ahead and to the right, by the heading, at the end."""
    place, yaw = last(heard, "LOCAL_POSITION_NED"), last(heard, "ATTITUDE").yaw
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * place.vx + sin * place.vy, cos * place.vy - sin * place.vx


def shown(heard: list[Heard]) -> set[tuple[int, int, int]]:
    beats = named(heard, "HEARTBEAT")
    return {(beat.custom_mode, beat.base_mode, beat.system_status) for beat in beats}


def texts(heard: list[Heard]) -> list[str]:
    """What was said, apart from the refusals that stand for silence."""
    said = [h.message.text for h in heard if h.message.get_type() == "STATUSTEXT"]
    return [t for t in said if "SET_POSITION_TARGET" not in t and "nsupported" not in t]


class Flight(NamedTuple):
    """A setpoint, and what comes of it: (speed ahead, speed to the right, climb) m/s, turn rad."""

    setpoint: Setpoint
    seconds: float
    velocity: tuple[float, float, float]
    turn: float = 0.0
    tolerance_m_s: float = 0.35  # noise of the estimate, and what is left of the step


FLIGHTS = {
    "body velocity": Flight(FORWARD, 4.0, (1.0, 0.0, 0.0)),
    "down is positive": Flight(Setpoint((0.0, 0.0, 0.7)), 3.0, (0.0, 0.0, -0.7)),
    "north": Flight(Setpoint((1.0, 0.0, 0.0), frame=LOCAL_NED), 4.0, (1.0, 0.0, 0.0)),
    "yaw rate to the right": Flight(Setpoint(yaw_rate=0.5), 4.0, (0.0, 0.0, 0.0), TURN),
    "yaw rate to the left": Flight(Setpoint(yaw_rate=-0.5), 4.0, (0.0, 0.0, 0.0), -TURN),
    "NaN forward": Flight(Setpoint((NAN, 0.0, 0.0)), 4.0, (0.0, 0.0, 0.0)),
    "NaN down": Flight(Setpoint((0.0, 0.0, NAN), frame=LOCAL_NED), 4.0, (0.0, 0.0, 0.0)),
    "NaN yaw rate": Flight(Setpoint((1.0, 0.0, 0.0), yaw_rate=NAN), 4.0, (1.0, 0.0, 0.0)),
    "beyond the limit": Flight(
        Setpoint((20.0, 0.0, 0.0)), 6.0, (12.0, 0.0, 0.0), tolerance_m_s=2.5
    ),
}


@pytest.mark.parametrize("name", FLIGHTS)
def test_what_a_setpoint_does(pilot: LockstepPilot, name: str) -> None:
    flight = FLIGHTS[name]
    start = last(pilot.fly(0.2), "ATTITUDE").yaw
    heard = pilot.fly(flight.seconds, flight.setpoint)
    ahead, right = speeds_along(heard)
    climb = -last(heard, "LOCAL_POSITION_NED").vz
    assert (ahead, right, climb) == pytest.approx(flight.velocity, abs=flight.tolerance_m_s)
    turned = math.remainder(last(heard, "ATTITUDE").yaw - start, math.tau)
    assert turned == pytest.approx(flight.turn, abs=0.15)
    assert texts(heard) == []
    assert shown(heard) == {(OFFBOARD, 145, ACTIVE)}
    recovered = pilot.fly(4.0, FORWARD)
    assert speeds_along(recovered)[0] == pytest.approx(1.0, abs=0.5)


def test_yaw_is_of_the_earth_and_velocity_of_the_body(pilot: LockstepPilot) -> None:
    """The yaw field in BODY_NED is absolute; the velocity is turned by the heading, and told so."""
    east = math.pi / 2
    for _ in range(2):  # the second time it faces there already
        turned = pilot.fly(6.0, Setpoint(mask=VELOCITY_AND_YAW, yaw=east))
        assert last(turned, "ATTITUDE").yaw == pytest.approx(east, abs=0.06)
    heard = pilot.fly(4.0, FORWARD)
    place = last(heard, "LOCAL_POSITION_NED")
    assert (place.vx, place.vy) == pytest.approx((0.0, 1.0), abs=0.35)
    echo = last(heard, "POSITION_TARGET_LOCAL_NED")
    assert (echo.coordinate_frame, echo.type_mask) == (1, 7)
    assert all(math.isnan(value) for value in (echo.x, echo.y, echo.z))
    assert (echo.vx, echo.vy, echo.vz) == pytest.approx((0.0, 1.0, 0.0), abs=0.1)
    assert echo.yaw == pytest.approx(east, abs=0.1)


def test_a_velocity_with_a_height(pilot: LockstepPilot) -> None:
    asked = Setpoint(
        (1.0, 0.0, 0.0), frame=LOCAL_NED, mask=VELOCITY_AND_HEIGHT, position=(0.0, 0.0, -12.0)
    )
    place = last(pilot.fly(6.0, asked), "LOCAL_POSITION_NED")
    assert place.z == pytest.approx(-12.0, abs=0.5)
    assert (place.vx, place.vy) == pytest.approx((1.0, 0.0), abs=0.35)


def test_few_setpoints_keep_offboard(pilot: LockstepPilot) -> None:
    """2.5 Hz is enough."""
    heard: list[Heard] = []
    for _ in range(10):
        heard += pilot.fly(IMAGE_S) + pilot.fly(7 * IMAGE_S, SILENCE)
    assert texts(heard) == []
    assert shown(heard) == {(OFFBOARD, 145, ACTIVE)}


@pytest.mark.parametrize(
    ("gap_s", "harmless"), [(0.6, True), (0.8, True), (0.95, True), (1.1, False), (1.3, False)]
)
def test_gaps(pilot: LockstepPilot, gap_s: float, *, harmless: bool) -> None:
    """The last velocity is kept until the time is over, and a short gap changes nothing."""
    choose(pilot, 0)
    pilot.fly(3.0, FORWARD)
    heard = pilot.fly(min(gap_s, 0.95) - IMAGE_S, SILENCE)
    assert speeds_along(heard)[0] == pytest.approx(1.0, abs=0.4)
    heard += pilot.fly(max(gap_s - 0.95, 0.0), SILENCE)
    heard += pilot.fly(2.0)
    assert texts(heard)[:1] == ([] if harmless else ["Failsafe activated\t"])
    beat = last(heard, "HEARTBEAT")
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (OFFBOARD, 145, ACTIVE)


class Loss(NamedTuple):
    """What COM_OBL_RC_ACT leads to: HEARTBEAT's fields."""

    action: int
    custom_mode: int
    base_mode: int


LOSSES = {
    "position": Loss(0, RTL, 157),  # by NAV_RCL_ACT
    "return": Loss(3, RTL, 157),
    "land": Loss(4, LAND, 157),
    "hold": Loss(5, HOLD, 157),
}


@pytest.mark.parametrize("name", LOSSES)
def test_a_lost_stream_leads_where_the_parameter_says_and_back(
    pilot: LockstepPilot, name: str
) -> None:
    """At once, without COM_FAIL_ACT_T; back by itself, in the next beat, without a text."""
    loss = LOSSES[name]
    choose(pilot, loss.action)
    pilot.fly(0.5)
    silent_s = pilot.time_s
    heard = pilot.fly(1.0 + 2 * BEAT_S, SILENCE)
    failed = next(h for h in heard if is_text("Failsafe activated")(h.message))
    low, high = LOST_S
    assert low - 2 * READ_S <= failed.time_s - silent_s <= high + 2 * READ_S
    assert (failed.message.text, failed.message.severity) == ("Failsafe activated\t", 2)
    is_beat = is_from(1, "HEARTBEAT")
    told_s = [h.time_s for h in heard if is_beat(h.message)]
    gaps_s = [b - a for a, b in itertools.pairwise(told_s)]
    assert max(gaps_s) < BEAT_S + READ_S + IMAGE_S
    assert min(gaps_s) > BEAT_S - READ_S - IMAGE_S  # a change of mode is not pushed
    later = [h for h in heard if h.time_s > failed.time_s + READ_S]
    assert shown(later) == {(loss.custom_mode, loss.base_mode, CRITICAL)}
    back = pilot.fly(BEAT_S + 2 * IMAGE_S)
    assert texts(back) == []
    beat = last(back, "HEARTBEAT")
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (OFFBOARD, 145, ACTIVE)


REFUSED = {(3, 0): "Position", (2, 0): "Altitude", (1, 0): "Manual", (4, 4): "Mission"}


@pytest.mark.parametrize("numbers", REFUSED, ids=REFUSED.get)
def test_a_mode_that_cannot_be_flown_is_refused(
    pilot: LockstepPilot, numbers: tuple[int, int]
) -> None:
    """Taken by the receiver, refused by the commander; nothing changes."""
    pilot.gcs.command(SET_MODE, 1.0, *map(float, numbers))
    heard = pilot.fly(BEAT_S + 2 * IMAGE_S)
    assert [ack.result for ack in named(heard, "COMMAND_ACK")] == [0, 1]
    expected = f"Switching to {REFUSED[numbers]} is currently not available\t"
    assert "".join(texts(heard)) == expected
    assert {m.severity for m in named(heard, "STATUSTEXT")} == {2}
    assert shown(heard) == {(OFFBOARD, 145, ACTIVE)}


def test_a_return_says_how_high(pilot: LockstepPilot) -> None:
    """From afar, at PX4's home in 491 m: "start return at 521 m (30 m above destination)"."""
    pilot.fly(6.0, Setpoint((20.0, 0.0, 0.0)))
    pilot.gcs.command(SET_MODE, 1.0, 4.0, 5.0)
    heard = pilot.fly(BEAT_S + 2 * IMAGE_S)
    said = "".join(texts(heard))
    height_m = int(said.removeprefix("RTL: start return at ").split()[0])
    assert said == f"RTL: start return at {height_m} m (30 m above destination)\t"
    assert height_m == pytest.approx(HOME_AMSL_M + 30.0, abs=1.5)  # home as it was estimated
    beat = last(heard, "HEARTBEAT")
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (RTL, 157, ACTIVE)


def test_a_ground_station_may_be_lost(pilot: LockstepPilot) -> None:
    """With NAV_DLL_ACT 0 it is said after 10 s, and nothing is done."""
    pilot.says_hello = False
    heard = pilot.fly(12.5)
    assert texts(heard) == ["Connection to ground station lost\t"]
    pilot.says_hello = True
    heard += pilot.fly(BEAT_S + 2 * IMAGE_S)
    assert texts(heard)[1:] == ["GCS connection regained\t"]
    assert {m.severity for m in named(heard, "STATUSTEXT")} == {6}
    assert shown(heard) == {(OFFBOARD, 145, ACTIVE)}


def choose(pilot: LockstepPilot, action: int) -> None:
    number = struct.unpack("<f", struct.pack("<i", action))[0]
    kind = mavlink.MAV_PARAM_TYPE_INT32
    pilot.gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"COM_OBL_RC_ACT", number, kind))
    pilot.fly_until(lambda m: m.get_type() == "PARAM_VALUE", "echo", STILL)
