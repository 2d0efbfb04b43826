"""Checks that know the vehicle and the mode: nothing is judged that was not there."""

from typing import Any

import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.text.summary_text import page
from tests.unit.flightstack.logs.kinds.made_vehicles import (
    ARDUPILOT,
    ARMED,
    COMPANION_TYPE,
    GCS,
    INVALID,
    PLANE,
    PX4,
    QUAD,
    ROVER,
    SECOND,
    SUB,
    Entry,
    Sender,
    Vehicle,
    beat,
    entries,
    every,
    facts_of,
    level,
    tlog,
)
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import START_US


def test_a_charge_that_nobody_knows_is_not_told() -> None:
    def status(_n: int) -> Any:
        return mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 15170, -1, -1, 0, 0, 0, 0, 0, 0)

    beats = every(1.0, Sender(), lambda _n: beat(QUAD, ARDUPILOT))
    facts = facts_of(beats + every(1.0, Sender(), status))
    assert "15.17 V to 15.17 V" in page(facts)
    assert level(facts, "battery") == "skipped"


@pytest.mark.parametrize("cells", [3, 6])
def test_battery_status_counts_too(cells: int) -> None:
    def status(n: int) -> Any:
        return mavlink.MAVLink_battery_status_message(
            0, 0, 0, 32767, [4000] * cells + [65535] * (10 - cells), -1, -1, -1, 50 - n % 40
        )

    beats = every(1.0, Sender(), lambda _n: beat(QUAD, ARDUPILOT))
    facts = facts_of(beats + every(1.0, Sender(), status))
    assert facts["battery"]["start_v"] == pytest.approx(4.0 * cells)
    assert facts["battery"]["start_percent"] == 50
    assert level(facts, "battery") == "warning"


def guided(mode: int, autopilot: int, extra: list[Entry]) -> Facts:
    return facts_of(entries(Vehicle(autopilot=autopilot, mode=mode)) + extra)


@pytest.mark.parametrize(
    ("autopilot", "mode", "name"), [(ARDUPILOT, 4, "GUIDED"), (PX4, 0x60000, "OFFBOARD")]
)
@pytest.mark.parametrize("orders", [0, 2])
def test_setpoints_are_judged_only_where_somebody_streams_them(
    autopilot: int, mode: int, name: str, orders: int
) -> None:
    station = Sender(255, 190)
    order = mavlink.MAVLink_set_position_target_local_ned_message
    extra = [
        (START_US + (20 + 9 * n) * SECOND, station.pack(order(n, 1, 1, 1, 0xDF8, *([0] * 11))))
        for n in range(orders)
    ]
    facts = guided(mode, autopilot, extra)
    assert level(facts, "setpoint_rate") == "skipped"
    reason = next(each["reason"] for each in facts["checks"] if each["name"] == "setpoint_rate")
    assert name in reason
    assert facts["offboard"] is None or orders


def test_a_companion_that_stops_streaming_is_still_an_error() -> None:
    companion = Sender(1, 191)
    make = mavlink.MAVLink_set_position_target_local_ned_message
    extra = [
        (
            START_US + n * 50_000,
            companion.pack(make(n, 1, 1, 1, 0x5C7, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0)),
        )
        for n in range(100, 400)
    ]
    assert level(guided(0x60000, PX4, extra), "setpoint_rate") == "ok"
    gap = [row for row in extra if not START_US + 12 * SECOND < row[0] < START_US + 15 * SECOND]
    assert level(guided(0x60000, PX4, gap), "setpoint_rate") == "error"


@pytest.mark.parametrize("kind", [PLANE, 22, ROVER, SUB])
def test_servos_of_a_plane_are_no_motors(kind: int) -> None:
    def outputs(n: int) -> Any:
        return mavlink.MAVLink_servo_output_raw_message(n, 0, 2000, 1000, 2000, 2000, 0, 0, 0, 0)

    rows = entries(Vehicle(type=kind)) + every(0.2, Sender(), outputs)
    assert level(facts_of(rows), "motor_saturation") == "skipped"
    throttle = mavlink.MAVLink_param_value_message(b"SERVO3_FUNCTION", 33, 4, 9, 0)
    told = [*rows, (START_US, Sender().pack(throttle))]
    expected = "warning" if kind in (PLANE, 22) else "skipped"
    assert level(facts_of(told), "motor_saturation") == expected


def test_a_failsafe_on_the_bench_endangers_no_flight() -> None:
    def critical(_n: int) -> Any:
        return mavlink.MAVLink_heartbeat_message(QUAD, PX4, 1, 0, 5, 3)

    assert level(facts_of(every(1.0, Sender(), critical)), "failsafe") == "warning"

    def in_flight(_n: int) -> Any:
        return mavlink.MAVLink_heartbeat_message(QUAD, PX4, 1 | ARMED, 0, 5, 3)

    assert level(facts_of(every(1.0, Sender(), in_flight)), "failsafe") == "error"


def test_decisions_are_the_companions_not_their_echo() -> None:
    data = make_flight(8.0)
    log = read_bytes(data)
    true = len(Flight(log).decisions)
    vehicle = Sender(1, 1)
    echoed = log["DEBUG_FLOAT_ARRAY"]
    rows = [
        (
            time_us + 900,
            vehicle.pack(
                mavlink.MAVLink_debug_float_array_message(us + 7, name.encode(), 0, values)
            ),
        )
        for time_us, us, name, values in zip(
            echoed.time_us[::2].tolist(),
            echoed["time_usec"][::2].tolist(),
            echoed["name"][::2].tolist(),
            echoed["data"][::2].tolist(),
            strict=True,
        )
    ]
    again = Flight(read_bytes(data + tlog(rows)))
    assert len(again.decisions) == true
    assert set(read_bytes(tlog(rows))["DEBUG_FLOAT_ARRAY"].component.tolist()) == {1}
    assert len(Flight(read_bytes(tlog(rows))).decisions) > 0


def test_links_are_judged_by_counters_that_are_one_links() -> None:
    one, two = Sender(255, 190), Sender(255, 190)
    two.link.seq = 120
    programs = every(0.15, one, lambda _n: beat(GCS, INVALID))
    programs += every(
        1.9, two, lambda _n: mavlink.MAVLink_request_data_stream_message(1, 1, 1, 4, 1)
    )
    facts = facts_of(entries(Vehicle()) + programs)
    assert level(facts, "link_loss") == "ok"
    assert "several programs" in page(facts)

    shared = Sender(1, 194)
    rows = []
    for n in range(400):
        shared.link.srcComponent = 220 if n % 5 else 194
        rows.append((START_US + n * 90_000, shared.pack(beat(COMPANION_TYPE, INVALID))))
    facts = facts_of(entries(Vehicle()) + rows)
    assert level(facts, "link_loss") == "ok"
    assert "counted together" in page(facts)

    lossy = [row for n, row in enumerate(entries(Vehicle())) if n % 10 != 3]
    assert level(facts_of(lossy), "link_loss") == "error"
