"""Failsafes of a real vehicle: each within its delay and a tick of vehicle time, at any speed.

The exact delays stand in the unit tests; here the vehicle's own log says when what happened, and
the process runs at real time, five times as fast, and as fast as it can.
"""

import signal
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.flight.tlogs import read
from tests.wire.vehicle_process import Vehicle, is_acknowledgement, is_text

pytestmark = pytest.mark.flight
ARM, SET_MODE = 400, 176
VELOCITY, OFFBOARD, STANDBY = 0x5C7, 6, 3
TICK_S = 0.004
LOSS_S = 20  # COM_OF_LOSS_T: long, so that a slow host keeps the stream alive at any speed
PARAMETERS = {
    "PX4_PARAM_COM_OBL_RC_ACT": "5",
    "PX4_PARAM_COM_OF_LOSS_T": str(LOSS_S),
    "PX4_PARAM_COM_DISARM_PRFLT": "-1",
}


def is_ready(message: Any) -> bool:
    """Whether it is a HEARTBEAT of the vehicle that says it can be armed."""
    return bool(message.get_type() == "HEARTBEAT" and message.system_status == STANDBY)


@pytest.mark.parametrize("speed", ["1", "5", "0"])
def test_loss_of_setpoints_acts_within_a_tick(tmp_path: Path, speed: str) -> None:
    log = tmp_path / "vehicle.tlog"
    environment = PARAMETERS | ({"PX4_PARAM_COM_OF_LOSS_T": "3"} if speed == "1" else {})
    loss_s = float(environment["PX4_PARAM_COM_OF_LOSS_T"])
    options = ("-q", f"--speed-factor={speed}", f"--log={log}")
    with Vehicle(*options, environment=environment) as vehicle:
        vehicle.wait_until_up()
        api = vehicle.api
        vehicle.gcs.say_hello()
        vehicle.gcs.wait_for(is_ready, timeout_s=20.0)
        setpoint = mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 8, VELOCITY, *(0.0,) * 11
        )
        api.send(setpoint)
        api.command(SET_MODE, 1.0, OFFBOARD)
        api.command(ARM, 1.0)
        api.wait_for(is_acknowledgement(ARM))
        api.send(setpoint)
        vehicle.gcs.wait_for(is_text("Failsafe activated"), timeout_s=30.0)
        vehicle.end(signal.SIGTERM)
    messages = read(log)
    last = max(m._timestamp for m in messages if m.get_type() == "SET_POSITION_TARGET_LOCAL_NED")
    acted = next(m._timestamp for m in messages if getattr(m, "text", "").startswith("Failsafe"))
    assert loss_s - TICK_S <= acted - last <= loss_s + 2 * TICK_S
