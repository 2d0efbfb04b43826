import math
import struct
from typing import Any

import pytest

from sitl.clock import SECOND_US, TICK_US
from sitl.mavlink.servers.parameter_server import HASH_INDEX, ParameterServer
from sitl.mavlink.servers.request import Request
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Packed, split, wrap
from tests.unit.sitl.mavlink.fakes import FakeOutlet, FakeParameters, make_request

INT32, UINT32, REAL32 = 6, 5, 9


class Bench:
    """A server, the outlet of one client, and the other links."""

    def __init__(self) -> None:
        self.parameters = FakeParameters()
        self.everywhere: list[Packed] = []
        self.server = ParameterServer(self.parameters, self.everywhere.append)
        self.outlet = FakeOutlet()
        self.request: Request = make_request(self.outlet)

    def read(self, name: str = "", index: int = -1) -> list[Any]:
        message = mavlink.MAVLink_param_request_read_message(1, 1, name.encode(), index)
        self.server.request_read(message, self.request)
        return self.outlet.take()

    def set(self, name: str, value: float, kind: int) -> list[Any]:
        message = mavlink.MAVLink_param_set_message(1, 1, name.encode(), value, kind)
        self.server.set(message, self.request)
        echoed, self.everywhere[:] = list(self.everywhere), []
        packets = [wrap(packed, sequence=0, system=1, component=1) for packed in echoed]
        return [split(raw)[0].message for raw in packets]

    def list_all(self) -> list[Any]:
        self.server.request_list(None, self.request)
        while self.server.is_listing:
            self.server.advance(TICK_US)
        return self.outlet.take()


def as_int(field: float) -> int:
    return int(struct.unpack("<i", struct.pack("<f", field))[0])


def as_field(value: int) -> float:
    return float(struct.unpack("<f", struct.pack("<i", value))[0])


def test_a_list_begins_with_the_hash_and_has_each_index_once() -> None:
    listed = Bench().list_all()
    assert (listed[0].param_id, listed[0].param_type) == ("_HASH_CHECK", UINT32)
    assert listed[0].param_index == HASH_INDEX
    assert [value.param_index for value in listed[1:]] == [0, 1, 2]
    assert {value.param_count for value in listed} == {3}


def test_integers_are_encoded_bytewise() -> None:
    _, timeout, system, speed = Bench().list_all()
    assert (timeout.param_type, as_int(timeout.param_value)) == (INT32, 10)
    assert (system.param_type, as_int(system.param_value)) == (INT32, 1)
    assert (speed.param_type, speed.param_value) == (REAL32, 12.0)


@pytest.mark.parametrize("value", [-1, -5_000_000, 0x7F800001, -(2**31)])
def test_no_integer_is_changed_by_its_way_through_a_float(value: int) -> None:
    bench = Bench()
    bench.parameters.values["MAV_SYS_ID"] = value
    bench.read("MAV_SYS_ID")
    (packed,) = bench.outlet.packed
    assert struct.unpack("<i", packed.payload[:4]) == (value,)


def test_a_list_goes_out_at_px4s_pace() -> None:
    bench = Bench()
    bench.parameters.values = {f"P{n:04}": float(n % 100) for n in range(2000)}
    bench.server = ParameterServer(bench.parameters, bench.everywhere.append)
    bench.server.request_list(None, bench.request)
    for _ in range(SECOND_US // TICK_US):
        bench.server.advance(TICK_US)
    assert 700 <= len(bench.outlet.take()) - 1 <= 1000


def test_the_hash_changes_with_a_value() -> None:
    bench = Bench()
    before = bench.read("_HASH_CHECK")[0].param_value
    assert bench.read("_HASH_CHECK")[0].param_value == before
    bench.set("MPC_XY_VEL_MAX", 8.0, REAL32)
    assert bench.read("_HASH_CHECK")[0].param_value != before


def test_a_ground_station_that_knows_the_hash_ends_the_list() -> None:
    bench = Bench()
    bench.server.request_list(None, bench.request)
    bench.set("_HASH_CHECK", 0.0, UINT32)
    assert not bench.server.is_listing


def test_reads_by_name_and_by_index() -> None:
    bench = Bench()
    assert [m.param_id for m in bench.read("MAV_SYS_ID")] == ["MAV_SYS_ID"]
    assert [m.param_id for m in bench.read(index=2)] == ["MPC_XY_VEL_MAX"]


@pytest.mark.parametrize(("name", "index"), [("NO_SUCH", -1), ("", 3), ("", -2), ("", 32767)])
def test_reading_what_is_not_there_stays_silent(name: str, index: int) -> None:
    assert Bench().read(name, index) == []


def test_a_change_is_echoed_on_all_links_with_its_index() -> None:
    bench = Bench()
    (echo,) = bench.set("MPC_XY_VEL_MAX", 8.5, REAL32)
    assert (echo.param_id, echo.param_value, echo.param_index) == ("MPC_XY_VEL_MAX", 8.5, 2)
    (echo,) = bench.set("COM_DL_LOSS_T", as_field(20), INT32)
    assert as_int(echo.param_value) == 20
    assert bench.parameters.values["COM_DL_LOSS_T"] == 20


@pytest.mark.parametrize(
    ("name", "kind"), [("NO_SUCH", REAL32), ("MPC_XY_VEL_MAX", INT32), ("MAV_SYS_ID", REAL32)]
)
def test_unknown_names_and_wrong_types_stay_silent_and_change_nothing(name: str, kind: int) -> None:
    bench = Bench()
    before = dict(bench.parameters.values)
    assert bench.set(name, 1.0, kind) == []
    assert bench.parameters.values == before


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 1e9])
def test_a_refused_value_is_answered_with_the_one_that_stays(value: float) -> None:
    (echo,) = Bench().set("MPC_XY_VEL_MAX", value, REAL32)
    assert echo.param_value == 12.0
