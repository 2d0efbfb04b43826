"""What the vehicle sends unprompted, and how often: the rates that a running PX4 kept."""

import itertools
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from sitl.mavlink.wire.newer_messages import CurrentEventSequence
from tests.wire.vehicle_process import Client, Vehicle, is_acknowledgement

pytestmark = pytest.mark.flight
SPEED_FACTOR = 5
SECONDS = 10  # of vehicle time
# PX4 measures 1 % low because its simulation ran slow; ours are exact.
GCS_RATES = {
    **dict.fromkeys(
        [
            *("ATTITUDE", "ATTITUDE_QUATERNION", "ATTITUDE_TARGET", "LOCAL_POSITION_NED"),
            *("GLOBAL_POSITION_INT", "POSITION_TARGET_LOCAL_NED", "SERVO_OUTPUT_RAW"),
        ],
        50.0,
    ),
    **dict.fromkeys(
        [
            *("HEARTBEAT", "ALTITUDE", "EXTENDED_SYS_STATE", "SYS_STATUS", "MISSION_CURRENT"),
            "SCALED_PRESSURE",
        ],
        1.0,
    ),
    **dict.fromkeys(["BATTERY_STATUS", "HOME_POSITION", "ESTIMATOR_STATUS", "CURRENT_MODE"], 0.5),
    **dict.fromkeys(["PING", "VIBRATION"], 0.1),
    CurrentEventSequence.msgname: 0.33,
    "GPS_RAW_INT": 5.0,
    "VFR_HUD": 4.0,
}
API_RATES = {
    "ATTITUDE": 100.0,
    **dict.fromkeys(["ATTITUDE_QUATERNION", "GLOBAL_POSITION_INT", "HIGHRES_IMU"], 50.0),
    **dict.fromkeys(["LOCAL_POSITION_NED", "ODOMETRY"], 30.0),
    **dict.fromkeys(
        [
            *("TIMESYNC", "ALTITUDE", "ATTITUDE_TARGET", "POSITION_TARGET_LOCAL_NED"),
            *("SERVO_OUTPUT_RAW", "VFR_HUD"),
        ],
        10.0,
    ),
    "GPS_RAW_INT": 8.0,
    **dict.fromkeys(["EXTENDED_SYS_STATE", "SYS_STATUS"], 5.0),
    **dict.fromkeys(
        [
            *("HEARTBEAT", "ESTIMATOR_STATUS", "PING", "SCALED_PRESSURE", "SYSTEM_TIME"),
            "MISSION_CURRENT",
        ],
        1.0,
    ),
    **dict.fromkeys(["BATTERY_STATUS", "HOME_POSITION", "VIBRATION", "CURRENT_MODE"], 0.5),
}


@pytest.fixture(scope="module")
def vehicle() -> Iterator[Vehicle]:
    with Vehicle("-q", f"--speed-factor={SPEED_FACTOR}") as vehicle:
        vehicle.wait_until_up()
        yield vehicle


def collect(client: Client, seconds: float) -> list[Any]:
    """Take what comes during some seconds of vehicle time, from one ATTITUDE to another."""
    client.forget()
    first = client.wait_for("ATTITUDE")
    taken = [first]
    for message in client.messages(60.0):
        taken.append(message)
        is_clock = message.get_type() == "ATTITUDE"
        if is_clock and message.time_boot_ms - first.time_boot_ms >= seconds * 1000:
            return taken[1:]
    raise AssertionError("the stream stopped")


def interval_us(client: Client, number: int, asked_us: int) -> int:
    """What MESSAGE_INTERVAL shows once an interval was asked for and accepted."""
    client.command(511, number, asked_us)
    assert client.wait_for(is_acknowledgement(511)).result == 0
    client.command(510, number)
    return int(client.wait_for("MESSAGE_INTERVAL").interval_us)


def sequences(messages: list[Any]) -> dict[int, list[int]]:
    numbers: dict[int, list[int]] = defaultdict(list)
    for message in messages:
        numbers[message.get_srcComponent()].append(message.get_seq())
    return numbers


@pytest.mark.parametrize(("link", "rates"), [("gcs", GCS_RATES), ("api", API_RATES)])
def test_rates_are_px4s_and_nothing_else_comes(
    vehicle: Vehicle, link: str, rates: dict[str, float]
) -> None:
    client: Client = getattr(vehicle, link)
    client.wait_for("HOME_POSITION")  # the first is sent once there is a home
    messages = [m for m in collect(client, SECONDS) if m.get_srcComponent() == 1]
    counted = Counter(message.get_type() for message in messages)
    assert set(counted) == set(rates)
    for name, rate_hz in rates.items():
        assert counted[name] == pytest.approx(rate_hz * SECONDS, abs=1.0), name


def test_heartbeats_and_score_of_the_other_components(vehicle: Vehicle) -> None:
    for client in (vehicle.gcs, vehicle.api):
        messages = collect(client, SECONDS)
        for component, expected in (
            (100, {"HEARTBEAT": 1, "CAMERA_TRIGGER": 20}),
            (25, {"HEARTBEAT": 1, "MISSION_CURRENT": 1}),
        ):
            counted = Counter(m.get_type() for m in messages if m.get_srcComponent() == component)
            assert set(counted) == set(expected)
            for name, rate_hz in expected.items():
                assert counted[name] == pytest.approx(rate_hz * SECONDS, abs=1.0)


def test_sequence_numbers_have_no_gaps(vehicle: Vehicle) -> None:
    for component, numbers in sequences(collect(vehicle.api, 3.0)).items():
        steps = {(b - a) & 0xFF for a, b in itertools.pairwise(numbers)}
        assert steps == {1}, component


def test_only_mavlink_2_of_system_1_is_spoken(vehicle: Vehicle) -> None:
    for message in collect(vehicle.gcs, 2.0):
        assert message.get_msgbuf()[0] == 0xFD
        assert message.get_srcSystem() == 1


def test_what_is_asked_of_a_companion_unprompted(vehicle: Vehicle) -> None:
    """TIMESYNC with boot time in ns and no answer yet; PING to everybody, counting up."""
    messages = [m for m in collect(vehicle.api, 4.0) if m.get_srcComponent() == 1]
    asked = [m for m in messages if m.get_type() == "TIMESYNC"]
    assert {m.tc1 for m in asked} == {0}
    now_ms = messages[-1].time_boot_ms
    assert asked[-1].ts1 / 1e6 == pytest.approx(now_ms, abs=110.0)
    pings = [m for m in messages if m.get_type() == "PING"]
    assert {(m.target_system, m.target_component) for m in pings} == {(0, 0)}
    assert {b.seq - a.seq for a, b in itertools.pairwise(pings)} == {1}


def test_ground_truth_comes_at_the_rate_that_is_asked_for(vehicle: Vehicle) -> None:
    client = vehicle.api
    client.command(511, mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION, 20_000)
    assert client.wait_for(is_acknowledgement(511)).result == 0
    truths = [m for m in collect(client, 2.0) if m.get_type() == "HIL_STATE_QUATERNION"]
    assert len(truths) == pytest.approx(100, abs=1)
    assert not [m for m in collect(vehicle.gcs, 1.0) if m.get_type() == "HIL_STATE_QUATERNION"]
    client.command(511, mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION, -1)
    assert client.wait_for(is_acknowledgement(511)).result == 0


def test_an_interval_of_0_leads_back_to_the_modes_default_not_to_the_start_up_rate(
    vehicle: Vehicle,
) -> None:
    client = vehicle.gcs
    for asked_us, rate_hz in ((50_000, 20), (0, 10), (20_000, 50)):
        shown_us = interval_us(client, mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION, asked_us)
        assert shown_us == 1_000_000 // rate_hz
        names = Counter(m.get_type() for m in collect(client, 2.0))
        assert names["ATTITUDE_QUATERNION"] == pytest.approx(2 * rate_hz, abs=1)
    shown_us = interval_us(client, mavlink.MAVLINK_MSG_ID_ATTITUDE, 0)
    assert shown_us == pytest.approx(1e6 / 15, abs=1)
    assert interval_us(client, mavlink.MAVLINK_MSG_ID_ATTITUDE, 20_000) == 20_000


def test_an_interval_of_minus_1_stops_a_message(vehicle: Vehicle) -> None:
    client, number = vehicle.gcs, mavlink.MAVLINK_MSG_ID_ALTITUDE
    assert interval_us(client, number, 50_000) == 50_000
    assert Counter(m.get_type() for m in collect(client, 1.0))["ALTITUDE"] >= 19
    assert interval_us(client, number, -1) == -1
    assert "ALTITUDE" not in {m.get_type() for m in collect(client, 1.0)}
    assert interval_us(client, number, 0) == 1_000_000
