"""The parameter protocol as a running PX4 speaks it."""

import signal
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.vehicle_process import Client, Vehicle

pytestmark = pytest.mark.flight
INT32, REAL32, UINT32 = 6, 9, 5
SILENCE_S = 0.5
DEFAULTS: dict[str, float] = {
    "COM_OF_LOSS_T": 1.0,
    "COM_OBL_RC_ACT": 0,
    "COM_DISARM_LAND": 2.0,
    "COM_DISARM_PRFLT": 10.0,
    "COM_RC_IN_MODE": 1,
    "COM_RCL_EXCEPT": 0,
    "NAV_RCL_ACT": 2,
    "NAV_DLL_ACT": 0,
    "COM_DL_LOSS_T": 10,
    "COM_RC_LOSS_T": 0.5,
    "COM_FAIL_ACT_T": 5.0,
    "COM_ARM_WO_GPS": 1,
    "COM_LOW_BAT_ACT": 3,
    "COM_KILL_DISARM": 5.0,
    "MIS_TAKEOFF_ALT": 2.5,
    "RTL_RETURN_ALT": 30.0,
    "RTL_DESCEND_ALT": 10.0,
    "RTL_LAND_DELAY": 0.0,
    "RTL_TYPE": 0,
    "NAV_ACC_RAD": 2.0,
    "NAV_MC_ALT_RAD": 0.8,
    "MPC_XY_VEL_MAX": 12.0,
    "MPC_XY_CRUISE": 5.0,
    "MPC_Z_VEL_MAX_UP": 3.0,
    "MPC_Z_VEL_MAX_DN": 1.5,
    "MPC_Z_V_AUTO_UP": 3.0,
    "MPC_Z_V_AUTO_DN": 1.5,
    "MPC_TKO_SPEED": 1.5,
    "MPC_LAND_SPEED": 0.7,
    "MPC_TKO_RAMP_T": 3.0,
    "MPC_ACC_HOR": 3.0,
    "MPC_ACC_HOR_MAX": 5.0,
    "MPC_ACC_UP_MAX": 4.0,
    "MPC_ACC_DOWN_MAX": 3.0,
    "MPC_JERK_MAX": 8.0,
    "MPC_JERK_AUTO": 4.0,
    "MPC_XY_P": 0.95,
    "MPC_XY_VEL_P_ACC": 1.8,
    "MPC_XY_VEL_I_ACC": 0.4,
    "MPC_XY_VEL_D_ACC": 0.2,
    "MPC_Z_P": 1.0,
    "MPC_Z_VEL_P_ACC": 4.0,
    "MPC_Z_VEL_I_ACC": 2.0,
    "MPC_Z_VEL_D_ACC": 0.0,
    "MPC_TILTMAX_AIR": 45.0,
    "MPC_TILTMAX_LND": 12.0,
    "MPC_MAN_TILT_MAX": 35.0,
    "MPC_THR_MIN": 0.12,
    "MPC_THR_MAX": 1.0,
    "MPC_YAWRAUTO_MAX": 60.0,
    "MPC_MAN_Y_MAX": 150.0,
    "MC_YAW_P": 2.8,
    "MC_YAWRATE_MAX": 200.0,
    "MC_ROLL_P": 4.0,
    "MC_PITCH_P": 4.0,
    "MC_YAWRATE_P": 0.2,
    "MC_ROLLRATE_P": 0.15,
    "MPC_LAND_ALT1": 10.0,
    "MPC_LAND_ALT2": 5.0,
    "LNDMC_Z_VEL_MAX": 0.25,
    "GF_ACTION": 2,
    "EKF2_HGT_REF": 1,
    "MAV_SYS_ID": 1,
    "MAV_COMP_ID": 1,
    "MAV_TYPE": 2,
    "MAV_PROTO_VER": 2,
    "BAT1_N_CELLS": 4,
    "SDLOG_MODE": 1,
    "CBRK_SUPPLY_CHK": 0,
    "COM_SPOOLUP_TIME": 1.0,
    "COM_MODE_ARM_CHK": 1,
}


@pytest.fixture(scope="module")
def vehicle() -> Iterator[Vehicle]:
    with Vehicle("-q") as vehicle:
        vehicle.wait_until_up()
        yield vehicle


def value_of(message: Any) -> float:
    if message.param_type == REAL32:
        return float(message.param_value)
    return int(struct.unpack("<i", struct.pack("<f", message.param_value))[0])


def field_of(value: float, kind: int) -> float:
    if kind == REAL32:
        return value
    return float(struct.unpack("<f", struct.pack("<i", int(value)))[0])


def list_all(client: Client) -> list[Any]:
    client.send(mavlink.MAVLink_param_request_list_message(1, 1))
    listed = [client.wait_for("PARAM_VALUE")]
    while len(listed) <= listed[0].param_count:
        listed.append(client.wait_for("PARAM_VALUE"))
    return listed


def read(client: Client, name: str, index: int = -1) -> None:
    client.send(mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), index))


def write(client: Client, name: str, value: float, kind: int, system: int = 1) -> None:
    field = field_of(value, kind)
    client.send(mavlink.MAVLink_param_set_message(system, 1, name.encode(), field, kind))


def stays_silent(client: Client) -> bool:
    return not [m for m in client.messages(SILENCE_S) if m.get_type() == "PARAM_VALUE"]


def test_the_list_begins_with_the_hash_and_has_each_index_once(vehicle: Vehicle) -> None:
    first, *values = list_all(vehicle.gcs)
    assert (first.param_id, first.param_index, first.param_type) == ("_HASH_CHECK", 65535, UINT32)
    assert [value.param_index for value in values] == list(range(first.param_count))
    assert {value.param_type for value in values} == {INT32, REAL32}
    assert len({value.param_id for value in values}) == len(values)


def test_defaults_are_px4s(vehicle: Vehicle) -> None:
    shown = {value.param_id: value_of(value) for value in list_all(vehicle.api)[1:]}
    for name, default in DEFAULTS.items():
        assert shown[name] == pytest.approx(default), name


def test_reads_by_name_and_index_agree(vehicle: Vehicle) -> None:
    client = vehicle.gcs
    read(client, "MPC_XY_VEL_MAX")
    by_name = client.wait_for("PARAM_VALUE")
    read(client, "", by_name.param_index)
    by_index = client.wait_for("PARAM_VALUE")
    assert by_name.to_dict() == by_index.to_dict()


@pytest.mark.parametrize(
    ("name", "value", "kind"), [("MPC_XY_CRUISE", 4.5, REAL32), ("COM_OBL_RC_ACT", 4, INT32)]
)
def test_a_change_is_echoed_on_both_links(
    vehicle: Vehicle, name: str, value: float, kind: int
) -> None:
    vehicle.api.forget()
    write(vehicle.gcs, name, value, kind)
    for client in (vehicle.gcs, vehicle.api):
        echo = client.wait_for("PARAM_VALUE")
        assert (echo.param_id, echo.param_type, value_of(echo)) == (name, kind, value)
        assert echo.param_index < echo.param_count


def test_what_is_unknown_mistyped_or_another_systems_stays_silent(vehicle: Vehicle) -> None:
    client = vehicle.gcs
    client.forget()
    read(client, "NO_SUCH_PARAM")
    write(client, "NO_SUCH_PARAM", 1.0, REAL32)
    write(client, "MPC_XY_VEL_MAX", 3, INT32)
    write(client, "MPC_XY_VEL_MAX", 3.0, REAL32, system=2)
    assert stays_silent(client)
    read(client, "MPC_XY_VEL_MAX")
    assert client.wait_for("PARAM_VALUE").param_value == 12.0


def test_a_value_that_cannot_be_is_answered_with_the_one_that_stays(vehicle: Vehicle) -> None:
    for value in (float("nan"), float("inf"), -5.0):
        write(vehicle.gcs, "MPC_XY_VEL_MAX", value, REAL32)
        assert vehicle.gcs.wait_for("PARAM_VALUE").param_value == 12.0


def test_changes_are_kept_from_run_to_run(tmp_path: Path) -> None:
    options = ("-q", f"--params={tmp_path / 'vehicle.params'}")
    with Vehicle(*options) as first:
        first.wait_until_up()
        write(first.api, "MPC_XY_CRUISE", 4.5, REAL32)
        first.api.wait_for("PARAM_VALUE")
        first.end(signal.SIGTERM)
    environment = {"PX4_PARAM_COM_OBL_RC_ACT": "5"}
    with Vehicle(*options, environment=environment) as second:
        second.wait_until_up()
        for name, value in (("MPC_XY_CRUISE", 4.5), ("COM_OBL_RC_ACT", 5)):
            read(second.api, name)
            assert value_of(second.api.wait_for("PARAM_VALUE")) == value
