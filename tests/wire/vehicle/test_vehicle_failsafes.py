"""Failsafes of a real vehicle: each within its delay and a tick of vehicle time, at any speed.

One vehicle meets one row after the other, armed on the ground; its own log then says when the cause
came in and when what followed was told. The process runs at real time, five times as fast, and as
fast as it can. What each action does in the air stands in the unit tests.
"""

import math
import signal
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.flight.tlogs import read
from tests.wire.vehicle_process import Client, Vehicle, is_acknowledgement, is_text

pytestmark = pytest.mark.flight
ARM, SET_MODE, SET_HOME, INJECT_FAILURE = 400, 176, 179, 420
VELOCITY, OFFBOARD, HOLD, STANDBY = 0x5C7, (6.0, 0.0), (4.0, 3.0), 3
GYRO, GPS, OK, OFF = 0.0, 4.0, 0.0, 1.0
COMPANION = 191
TICK_S = 0.004
LOG_S = 1e-5  # the log's times are whole microseconds, their last bits a link's number
HOLD_S = 1.0  # COM_FAIL_ACT_T
DRAIN_S, CRITICAL = 2.0, 0.07  # SIM_BAT_DRAIN, BAT_CRIT_THR
ACTIVATED, RETURNS = "Failsafe activated", "RTL: start return"
ENVIRONMENT = {
    "COM_DISARM_PRFLT": -1.0,
    "COM_FAIL_ACT_T": HOLD_S,
    "COM_DL_LOSS_T": 5,
    "COM_OBL_RC_ACT": 3,  # return
    "NAV_RCL_ACT": 2,  # return
    "GF_ACTION": 3,  # return
    "SIM_BAT_MIN_PCT": 100.0,  # full, until its row
    "SYS_FAILURE_EN": 1,
}


class Cause(NamedTuple):
    """The message that begins it all: the last one of that name that meets the condition."""

    name: str
    meets: Callable[[Any], bool] = lambda _: True


class Row(NamedTuple):
    """What is provoked, and what is told how long after its cause."""

    name: str
    provoke: Callable[[Vehicle], None]
    cause: Cause
    told: tuple[tuple[str, float], ...]  # beginnings of texts, s of vehicle time
    slack_s: float = 0.0  # beyond the tick
    mend: Callable[[Vehicle], None] = lambda _: None


def set_parameter(client: Client, name: str, value: float) -> None:
    """Set a parameter, its integers bytewise."""
    is_integer = isinstance(value, int)
    number = struct.unpack("<f", struct.pack("<i", value))[0] if is_integer else value
    kind = mavlink.MAV_PARAM_TYPE_INT32 if is_integer else mavlink.MAV_PARAM_TYPE_REAL32
    client.send(mavlink.MAVLink_param_set_message(1, 1, name.encode(), number, kind))


def lose_setpoints(vehicle: Vehicle) -> None:
    numbers = (0.0,) * 11
    setpoint = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 8, VELOCITY, *numbers)
    vehicle.api.send(setpoint)
    vehicle.api.command(SET_MODE, 1.0, *OFFBOARD)
    vehicle.api.send(setpoint)


def lose_ground_station(vehicle: Vehicle) -> None:
    set_parameter(vehicle.gcs, "NAV_DLL_ACT", 2)
    vehicle.gcs.say_hello()


def lose_sticks(vehicle: Vehicle) -> None:
    vehicle.gcs.send(mavlink.MAVLink_manual_control_message(1, 0, 0, 500, 0, 0))


def lose_companion(vehicle: Vehicle) -> None:
    codec = mavlink.MAVLink(None, srcSystem=1, srcComponent=COMPANION)
    assert vehicle.api.vehicle is not None
    hello = mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3)
    vehicle.api.socket.sendto(hello.pack(codec), vehicle.api.vehicle)


def leave_fence(vehicle: Vehicle) -> None:
    vehicle.gcs.command(SET_HOME, 0.0, 0.0, 0.0, math.nan, 47.399, 8.5456, 489.4)  # 140 m away
    set_parameter(vehicle.gcs, "GF_MAX_HOR_DIST", 50.0)


def drain_battery(vehicle: Vehicle) -> None:
    set_parameter(vehicle.gcs, "SIM_BAT_MIN_PCT", 100.0 * (CRITICAL - 0.01))
    set_parameter(vehicle.gcs, "SIM_BAT_DRAIN", DRAIN_S)


def fail(unit: float, kind: float) -> Callable[[Vehicle], None]:
    return lambda vehicle: vehicle.gcs.command(INJECT_FAILURE, unit, kind)


def is_command(number: int) -> Callable[[Any], bool]:
    return lambda message: message.command == number


def is_parameter(name: str) -> Callable[[Any], bool]:
    return lambda message: message.param_id == name


def then_returns(delay_s: float) -> tuple[tuple[str, float], ...]:
    return ((ACTIVATED, delay_s), (RETURNS, delay_s + HOLD_S))


def silences(setpoints_s: float) -> tuple[Row, ...]:
    """The rows for somebody who is heard no more."""
    at_once = ((ACTIVATED, setpoints_s), (RETURNS, setpoints_s))
    return (
        Row("setpoints", lose_setpoints, Cause("SET_POSITION_TARGET_LOCAL_NED"), at_once),
        Row(
            "ground station",
            lose_ground_station,
            Cause("HEARTBEAT", lambda m: m.type == mavlink.MAV_TYPE_GCS),
            then_returns(5.0),
            mend=lambda vehicle: set_parameter(vehicle.gcs, "NAV_DLL_ACT", 0),
        ),
        Row("sticks", lose_sticks, Cause("MANUAL_CONTROL"), then_returns(0.5)),
        Row(
            "companion",
            lose_companion,
            Cause("HEARTBEAT", lambda m: m.get_srcComponent() == COMPANION),
            (("Connection to mission computer lost", 5.0),),
        ),
    )


def hazards() -> tuple[Row, ...]:
    """The other rows; after the last two nobody flies any more."""
    return (
        Row(
            "fence",
            leave_fence,
            Cause("PARAM_SET", is_parameter("GF_MAX_HOR_DIST")),
            then_returns(0.0),
            slack_s=0.2,  # PX4 looks five times a second
            mend=lambda vehicle: set_parameter(vehicle.gcs, "GF_MAX_HOR_DIST", 0.0),
        ),
        Row(
            "position",
            fail(GPS, OFF),
            Cause("COMMAND_LONG", is_command(INJECT_FAILURE)),
            ((ACTIVATED, 5.0), ("No valid estimate", 5.0)),
            mend=fail(GPS, OK),
        ),
        Row(
            "battery",
            drain_battery,
            Cause("PARAM_SET", is_parameter("SIM_BAT_DRAIN")),
            then_returns(DRAIN_S * (1.0 - CRITICAL)),
            slack_s=TICK_S,  # the charge is read once a tick
        ),
        Row(
            "attitude",
            fail(GYRO, OFF),
            Cause("COMMAND_LONG", is_command(INJECT_FAILURE)),
            (("Flight termination active", 0.0),),
            slack_s=TICK_S,  # the gyro is read once a tick
        ),
    )


def arm(vehicle: Vehicle) -> None:
    """Be armed in HOLD, as before the first row, whatever has been."""
    gcs = vehicle.gcs
    gcs.command(ARM, 0.0, 21196.0)
    assert gcs.wait_for(is_acknowledgement(ARM)).result == 0
    gcs.command(SET_MODE, 1.0, *HOLD)
    while True:  # until what was mended is known to be well
        gcs.command(ARM, 1.0)
        if gcs.wait_for(is_acknowledgement(ARM)).result == 0:
            return
        gcs.wait_for("ATTITUDE")


def is_ready(message: Any) -> bool:
    """Whether it is a HEARTBEAT of the vehicle that says it can be armed."""
    return bool(message.get_type() == "HEARTBEAT" and message.system_status == STANDBY)


@pytest.mark.parametrize(("speed", "setpoints_s"), [("1", 1.0), ("5", 5.0), ("0", 20.0)])
def test_every_failsafe_acts_within_a_tick(tmp_path: Path, speed: str, setpoints_s: float) -> None:
    """The setpoints' time is long where the vehicle runs ahead of a slow host's clients."""
    log = tmp_path / "vehicle.tlog"
    parameters = ENVIRONMENT | {"COM_OF_LOSS_T": setpoints_s}
    environment = {f"PX4_PARAM_{name}": str(value) for name, value in parameters.items()}
    table = (*silences(setpoints_s), *hazards())
    with Vehicle("-q", f"--speed-factor={speed}", f"--log={log}", environment=environment) as sitl:
        sitl.wait_until_up()
        sitl.gcs.say_hello()
        sitl.gcs.wait_for(is_ready, timeout_s=20.0)
        for row in table:
            if row.name != "attitude":  # in the air or not: after an empty battery nobody arms
                arm(sitl)
            row.provoke(sitl)
            sitl.gcs.wait_for(is_text(row.told[-1][0]), row.name, timeout_s=30.0)
            row.mend(sitl)
        sitl.end(signal.SIGTERM)
    messages = read(log)
    for row in table:
        messages = _check(row, messages)


def _check(row: Row, messages: list[Any]) -> list[Any]:
    """Compare a row's delays with the log; what comes after it."""
    end = next(n for n, m in enumerate(messages) if _text(m).startswith(row.told[-1][0]))
    name, meets = row.cause
    begun = [m for m in messages[:end] if m.get_type() == name and meets(m)][-1]
    told = [m for m in messages[: end + 1] if m._timestamp >= begun._timestamp]
    for text, delay_s in row.told:
        acted = next(m for m in told if _text(m).startswith(text))
        late_s = acted._timestamp - begun._timestamp - delay_s
        assert -LOG_S <= late_s <= row.slack_s + TICK_S + LOG_S, (row.name, text, late_s)
    return messages[end + 1 :]


def _text(message: Any) -> str:
    return str(getattr(message, "text", ""))
