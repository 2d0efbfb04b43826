"""One notion of the vehicle: who flies, what it is, and what it did, by what it is."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.cli import main
from flightstack.logs.columns.expression import holds
from flightstack.logs.columns.senders import find_participants, main_autopilot
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.parameters import read_parameters
from flightstack.logs.text.summary_text import page
from scripts.make_logs import (
    ARDUPILOT,
    ARMED,
    BOAT,
    GCS,
    GENERIC,
    INVALID,
    PLANE,
    PX4,
    QUAD,
    ROVER,
    SUB,
    MadeSender,
    MadeVehicle,
    entries,
    tlog,
)
from tests.unit.flightstack.logs.kinds.made_vehicles import beat, every, facts_of
from tests.unit.flightstack.logs.made_logs import START_US


@pytest.mark.parametrize(
    ("system", "component", "kind"), [(255, 190, 16), (252, 1, 6), (255, 0, 16)]
)
@pytest.mark.parametrize("step_s", [0.05, 0.5])
def test_the_vehicle_is_the_one_that_flies_not_who_beats_most(
    system: int, component: int, kind: int, step_s: float
) -> None:
    station = every(step_s, MadeSender(system, component), lambda _n: beat(kind, GENERIC))
    facts = facts_of(entries(MadeVehicle(type=PLANE)) + station)
    assert facts["vehicle"] == {"system": 1, "component": 1, "kind": "ardupilotmega fixed wing"}
    assert facts["other_vehicles"] == []
    roles = {(each["system"], each["component"]): each["role"] for each in facts["links"]}
    assert roles[system, component] == "ground station"


@pytest.mark.parametrize("other", [2, 77])
def test_a_second_vehicle_is_named_and_can_be_chosen(other: int, tmp_path: Path) -> None:
    rows = entries(MadeVehicle(autopilot=PX4)) + entries(
        MadeVehicle(type=ROVER, speed_m_s=2.0), MadeSender(other)
    )
    facts = facts_of(rows)
    assert [each["system"] for each in facts["other_vehicles"]] == [other]
    assert f"also      system {other}: ardupilotmega ground rover" in page(facts)
    chosen = facts_of(rows, other)
    assert chosen["vehicle"]["system"] == other
    assert (chosen["flights"], chosen["outing"], chosen["outings"]) == (0, "drive", 1)
    with pytest.raises(UnknownNameError, match=f"holds 1, {other}"):
        facts_of(rows, 9)
    path = tmp_path / "two.tlog"
    path.write_bytes(tlog(rows))
    assert main([str(path), "--system", "9"]) == 2


def test_conditions_read_the_vehicle_whoever_else_sends_that_message() -> None:
    rows = entries(MadeVehicle(mode=4)) + every(
        0.3, MadeSender(255, 190), lambda _n: beat(GCS, INVALID, 0)
    )
    log = read_bytes(tlog(rows))
    vehicle = main_autopilot(find_participants(log), None)
    attitude = np.flatnonzero(log.packets.msgid == 30)
    assert holds("HEARTBEAT.custom_mode == 4", log, attitude, vehicle).all()
    assert not holds("HEARTBEAT.custom_mode == 4", log, attitude).all()


@pytest.mark.parametrize("component", [190, 0, 1])
def test_parameters_are_the_vehicles_whoever_fetched_them(component: int) -> None:
    teller, gimbal = MadeSender(1, component), MadeSender(1, 154)
    count = 40

    def parameter(n: int) -> Any:
        return mavlink.MAVLink_param_value_message(b"P_%d" % n, n, 9, count, n)

    rows = entries(MadeVehicle())
    rows += [(START_US + n, teller.pack(parameter(n))) for n in range(count)]
    rows += [(START_US, gimbal.pack(mavlink.MAVLink_param_value_message(b"GMB_X", 1, 9, 1, 0)))]
    values = read_parameters(Flight(read_bytes(tlog(rows)))).values
    assert len(values) == count
    assert "GMB_X" not in values


def noisy(amplitude: float, height: float, seed: int) -> Callable[[float], float]:
    noise = np.random.default_rng(seed).uniform(-amplitude, amplitude, 1000)

    def down(t: float) -> float:
        up = max(0.0, min(1.0, (t - 15) / 6, (45 - t) / 6))
        return float(-height * up + noise[round(t * 10)])

    return down


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(("amplitude", "height"), [(0.3, 30.0), (1.5, 40.0), (2.5, 60.0)])
def test_a_plane_with_a_noisy_height_flies_once(amplitude: float, height: float, seed: int) -> None:
    facts = facts_of(entries(MadeVehicle(type=PLANE, down=noisy(amplitude, height, seed))))
    assert facts["flights"] == 1
    assert 20 < facts["flight_time_s"] < 35


@pytest.mark.parametrize(("kind", "noun"), [(ROVER, "drive"), (BOAT, "trip")])
@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_what_drives_never_flies(kind: int, noun: str, speed: float) -> None:
    facts = facts_of(entries(MadeVehicle(type=kind, speed_m_s=speed, down=noisy(1.0, 0.0, 3))))
    assert (facts["flights"], facts["outing"], facts["outings"]) == (0, noun, 1)
    assert facts["distance_m"] == pytest.approx(40 * speed, rel=0.05)
    assert "in the air" not in page(facts)


@pytest.mark.parametrize("depth", [3.0, 20.0])
def test_a_submarine_dives(depth: float) -> None:
    def down(t: float) -> float:
        return depth * max(0.0, min(1.0, (t - 10) / 8, (50 - t) / 8))

    facts = facts_of(entries(MadeVehicle(type=SUB, down=down)))
    assert (facts["flights"], facts["outing"], facts["outings"]) == (0, "dive", 1)
    assert facts["max_depth_m"] == pytest.approx(depth)
    assert facts["ends"] == "surfaced and disarmed"


@pytest.mark.parametrize("unknown_until_s", [11.0, 25.0])
def test_a_position_that_comes_late_is_still_a_flight(unknown_until_s: float) -> None:
    plain = MadeVehicle().down
    rows = entries(
        MadeVehicle(autopilot=PX4, down=lambda t: np.nan if t < unknown_until_s else plain(t))
    )
    assert facts_of(rows)["flights"] == 1


@pytest.mark.parametrize("end_s", [30.0, 33.7])
def test_nothing_is_disarmed_that_was_not(end_s: float) -> None:
    facts = facts_of(entries(MadeVehicle(end_s=end_s)))
    assert facts["ends"] == "in the air, armed"
    assert "disarmed" not in page(facts)


def test_landed_state_is_believed_where_it_is_told() -> None:
    def state(n: int) -> Any:
        return mavlink.MAVLink_extended_sys_state_message(0, 2 if 20 <= n < 30 else 1)

    told = entries(MadeVehicle()) + every(1.0, MadeSender(), state)
    assert facts_of(told)["flight_time_s"] == pytest.approx(10.0, abs=0.1)
    silent = entries(MadeVehicle()) + every(
        1.0, MadeSender(), lambda _n: mavlink.MAVLink_extended_sys_state_message(0, 0)
    )
    assert facts_of(silent)["flight_time_s"] > 30


@pytest.mark.parametrize(
    ("autopilot", "mode", "name"), [(PX4, 0x0304, "AUTO.LOITER"), (ARDUPILOT, 5, "LOITER")]
)
def test_high_latency_alone_tells_mode_position_and_battery(
    autopilot: int, mode: int, name: str
) -> None:
    def slow(n: int) -> Any:
        values = [0] * 27
        message = mavlink.MAVLink_high_latency2_message(*values)
        message.timestamp, message.type, message.autopilot = n * 10_000, QUAD, autopilot
        message.custom_mode, message.battery, message.altitude = mode, 80 - n, 10
        return message

    facts = facts_of(every(10.0, MadeSender(), slow, 300))
    assert facts["vehicle"]["system"] == 1
    assert [each["mode"] for each in facts["modes"]] == [name]
    assert facts["position_from"] == "HIGH_LATENCY2"
    assert (facts["battery"]["start_percent"], facts["battery"]["end_percent"]) == (80, 51)
    assert "None" not in page(facts)


def test_the_older_high_latency_tells_whether_it_has_landed() -> None:
    def slow(n: int) -> Any:
        values: list[Any] = [0] * len(mavlink.MAVLink_high_latency_message.fieldnames)
        message = mavlink.MAVLink_high_latency_message(*values)
        in_air = 5 <= n < 25
        message.base_mode, message.landed_state = 1 | ARMED * in_air, 1 + in_air
        return message

    facts = facts_of(every(10.0, MadeSender(), slow, 300))
    assert (facts["flights"], facts["flight_time_s"]) == (1, 200.0)
