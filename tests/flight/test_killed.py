"""What each side does when the other is killed, or the flight is interrupted."""

import signal
from pathlib import Path
from typing import Any

import pytest

from tests.flight import tlogs
from tests.flight.clients.observer import OFFBOARD, Observer
from tests.flight.processes import pair

pytestmark = pytest.mark.flight
CALM = ("--noise=0,0", "--laps=4")
START_S = 60.0  # from the processes' start to the first gate
LOST_S = 8.0  # 3 s of silence, 1 s of calling, then the end of the process
OFFBOARD_LOSS_S = 1.0  # PX4 COM_OF_LOSS_T
CONTROL_TICK_S = 0.004
LINK_BITS_S = 4e-6  # the tlog's times carry the link's number in their lowest bits


def test_vehicle_leaves_offboard_when_the_companion_is_killed(tmp_path: Path) -> None:
    with pair(tmp_path, *CALM) as flight, Observer(flight.instance) as observer:
        observer.wait_for_gate(0, timeout_s=START_S, running=flight.companion)
        flight.companion.send_signal(signal.SIGKILL)
        observer.wait_for_text("Failsafe activated", timeout_s=30.0)

        def left_offboard(message: Any) -> bool:
            return bool(message.get_type() == "HEARTBEAT" and message.custom_mode != OFFBOARD)

        beat = observer.wait_for(left_offboard, "mode other than OFFBOARD", timeout_s=5.0)
        assert beat.system_status == 5  # critical: a failsafe flies
    messages = tlogs.read(flight.vehicle_log)
    last_setpoint = tlogs.of_type(messages, "SET_POSITION_TARGET_LOCAL_NED")[-1]
    failsafe = next(m for m in tlogs.of_type(messages, "STATUSTEXT") if "Failsafe" in m.text)
    silence_s = failsafe._timestamp - last_setpoint._timestamp
    assert silence_s >= OFFBOARD_LOSS_S - LINK_BITS_S
    assert silence_s <= OFFBOARD_LOSS_S + 2 * CONTROL_TICK_S + LINK_BITS_S


def test_companion_says_so_when_the_vehicle_is_killed(tmp_path: Path) -> None:
    briefly = ("--reach=1",)
    with (
        pair(tmp_path, *CALM, companion=briefly) as flight,
        Observer(flight.instance) as observer,
    ):
        observer.wait_for_gate(0, timeout_s=START_S, running=flight.companion)
        flight.vehicle.send_signal(signal.SIGKILL)
        assert flight.companion.wait(timeout=LOST_S) == 3
    assert "vehicle lost" in flight.companion_output.read_text().lower()
    messages = tlogs.read(flight.companion_log)
    assert not tlogs.of_type(messages, "BAD_DATA")
    assert tlogs.of_type(messages, "SET_POSITION_TARGET_LOCAL_NED")
    assert _is_whole(flight.companion_log)


def test_interrupted_flight_lands_and_ends_with_130(tmp_path: Path) -> None:
    with pair(tmp_path, *CALM) as flight, Observer(flight.instance) as observer:
        observer.wait_for_gate(0, timeout_s=START_S, running=flight.companion)
        flight.companion.send_signal(signal.SIGINT)
        observer.wait_for_text("Disarmed by landing", timeout_s=60.0)
        assert flight.companion.wait(timeout=10.0) == 130


def _is_whole(log: Path) -> bool:
    """Whether the file ends with a record's last byte: 8 bytes of time, 12 around a payload."""
    data = log.read_bytes()
    at = 0
    while at + 10 < len(data):
        assert data[at + 8] == 0xFD, f"no MAVLink 2 frame at {at}"
        at += 8 + 12 + data[at + 9] + (13 if data[at + 10] & 1 else 0)
    return at == len(data)
