"""The parameter protocol as a running PX4 speaks it."""

import signal
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.observed.parameters import DEFAULTS
from tests.wire.vehicle_process import Client, Vehicle

pytestmark = pytest.mark.flight
INT32, REAL32, UINT32 = 6, 9, 5
SILENCE_S = 0.5
LIST_RATE_HZ = 950


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


def test_what_the_airframe_says_is_of_the_airframe(vehicle: Vehicle) -> None:
    """PX4's SIH quadrotor shows 10040 and 0.5, its x500 these."""
    for name, value in (("SYS_AUTOSTART", 4001), ("MPC_THR_HOVER", 0.6)):
        read(vehicle.gcs, name)
        assert value_of(vehicle.gcs.wait_for("PARAM_VALUE")) == pytest.approx(value)


def test_the_list_comes_at_px4s_pace(vehicle: Vehicle) -> None:
    """PX4: 908 in 0.95 s."""
    client = vehicle.gcs
    begun_s = time.monotonic()
    listed = list_all(client)
    took_s = time.monotonic() - begun_s
    assert took_s >= 0.8 * len(listed) / LIST_RATE_HZ  # not in one burst, which a link would drop


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
