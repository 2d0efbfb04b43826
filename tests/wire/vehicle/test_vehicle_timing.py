"""When things happen on a real vehicle: take-off, landing, gaps in the stream, a step; by its log.

Times are vehicle time, from the vehicle's own log; clients only have to be quick enough.
"""

import itertools
import math
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.flight.tlogs import of_type, read, seconds_until
from tests.wire.vehicle_process import Vehicle, is_from, is_text

pytestmark = pytest.mark.flight
NAN = math.nan
ARM, TAKE_OFF, LAND, SET_MODE = 400, 22, 21, 176
ON_GROUND, IN_AIR, TAKING_OFF, LANDING = 1, 2, 3, 4
HOLD, POSCTL, OFFBOARD, LAND_MODE = 0x03040000, 0x00030000, 0x00060000, 0x06040000
Vector3 = tuple[float, float, float]
STANDBY, VELOCITY, BODY_NED = 3, 0x5C7, 8
WIDER = 0.15
SPEED = 2
SETPOINT_S = 0.05 / SPEED  # wall time: 20 Hz for the vehicle


class Pilot:
    """A vehicle, and a stream of body velocities to it."""

    def __init__(self, vehicle: Vehicle, log: Path) -> None:
        self.vehicle, self.gcs, self.log = vehicle, vehicle.gcs, log
        self._sent_s = self._hello_s = 0.0

    def wait_for(self, condition: Callable[[Any], bool], what: str) -> Any:
        return self.gcs.wait_for(condition, what, timeout_s=60.0)

    def mode(self, custom_mode: int) -> None:
        self.wait_for(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.custom_mode == custom_mode, hex(custom_mode)
        )

    def landed_state(self, state: int) -> None:
        self.wait_for(
            lambda m: m.get_type() == "EXTENDED_SYS_STATE" and m.landed_state == state, str(state)
        )

    def fly(self, seconds: float, velocity: Vector3 | None) -> None:
        """Stream for some vehicle time, or be silent."""
        end_ms = None
        for message in self.gcs.messages(60.0):
            now_s = time.monotonic()
            if now_s - self._hello_s > 1.0:
                self._hello_s = now_s
                self.gcs.say_hello()
            if velocity is not None and now_s - self._sent_s >= SETPOINT_S:
                self._sent_s = now_s
                self.send(velocity)
            if message.get_type() == "ATTITUDE":
                end_ms = end_ms or message.time_boot_ms + 1000.0 * seconds
                if message.time_boot_ms >= end_ms:
                    return
        raise AssertionError("time does not pass")

    def send(self, velocity: Vector3) -> None:
        numbers = (0.0, 0.0, 0.0, *velocity, *(0.0,) * 5)
        self.gcs.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, BODY_NED, VELOCITY, *numbers
            )
        )

    def take_off(self, altitude_m: float = NAN) -> None:
        self.gcs.command(ARM, 1.0)
        self.gcs.command(TAKE_OFF, *[NAN] * 6, altitude_m)
        self.landed_state(IN_AIR)
        self.mode(HOLD)

    def end(self) -> list[Any]:
        self.vehicle.end(signal.SIGTERM)
        return read(self.log)


@pytest.fixture
def pilot(tmp_path: Path) -> Iterator[Pilot]:
    log = tmp_path / "vehicle.tlog"
    with Vehicle("-q", f"--speed-factor={SPEED}", f"--log={log}", "--noise=0,0") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello()
        vehicle.gcs.wait_for(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.system_status == STANDBY, "readiness"
        )
        yield Pilot(vehicle, log)


def test_home_is_known_before_the_vehicle_is_ready(tmp_path: Path) -> None:
    """PX4: a home some 4 s after boot; "Ready for takeoff!" 8 to 9 s after the process's start."""
    log = tmp_path / "vehicle.tlog"
    with Vehicle("-q", f"--speed-factor={SPEED}", f"--log={log}", "--ready-after=8.5") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello()
        vehicle.gcs.wait_for(is_text("Ready for takeoff"), timeout_s=30.0)
        vehicle.end(signal.SIGTERM)
    messages = read(log)
    started_s = messages[0]._timestamp
    home_s = of_type(messages, "HOME_POSITION")[0]._timestamp - started_s
    ready_s = seconds_until(messages, "STATUSTEXT", lambda m: m.text.startswith("Ready"), started_s)
    assert 4.0 <= home_s <= 6.0  # it is sent every 2 s
    assert 8.0 <= ready_s <= 9.0
    early = {
        m.system_status
        for m in of_type(messages, "HEARTBEAT")
        if (m.get_srcSystem(), m.get_srcComponent()) == (1, 1)
        and m._timestamp - started_s < ready_s
    }
    assert early == {0}


def test_take_off_and_landing_take_their_time(pilot: Pilot) -> None:
    """PX4: TAKEOFF +1.8 s, IN_AIR +6.3 s, HOLD +6.4 s; down in 9.3 to 10.2 s, disarmed 2 s later.

    EXTENDED_SYS_STATE comes at 1 Hz on this link: that much may be added.
    """
    pilot.take_off()
    pilot.gcs.command(LAND)
    pilot.landed_state(LANDING)
    pilot.landed_state(ON_GROUND)
    pilot.wait_for(is_text("Disarmed by landing"), "disarming")
    messages = pilot.end()
    commands = {m.command: m._timestamp for m in of_type(messages, "COMMAND_LONG")}

    def state(number: int, since_s: float) -> float:
        return seconds_until(
            messages, "EXTENDED_SYS_STATE", lambda m: m.landed_state == number, since_s
        )

    def text(beginning: str, since_s: float) -> float:
        return seconds_until(
            messages, "STATUSTEXT", lambda m: m.text.startswith(beginning), since_s
        )

    off_s, down_s = commands[ARM], commands[LAND]
    assert 0.8 <= state(TAKING_OFF, off_s) <= 2.8
    assert 5.3 <= state(IN_AIR, off_s) <= 7.3
    flying_s = off_s + 2.0  # it was in HOLD when it was armed, too
    held = seconds_until(messages, "HEARTBEAT", lambda m: m.custom_mode == HOLD, flying_s)
    assert 5.4 <= held + 2.0 <= 7.4
    assert state(LANDING, down_s) <= 1.1
    landed_s = text("Landing detected", down_s)
    assert 9.3 * (1.0 - WIDER) - 1.0 <= landed_s <= 10.2 * (1.0 + WIDER)
    assert text("Disarmed by landing", down_s) - landed_s == pytest.approx(2.0, abs=0.1)


def test_short_gaps_are_harmless_and_long_ones_are_not(pilot: Pilot) -> None:
    """PX4: gaps of 0.6, 0.8 and 0.95 s harmless; 1.1 and 1.3 s: failsafe after 0.98 to 1.09 s."""
    pilot.take_off()
    still = (0.0, 0.0, 0.0)
    pilot.fly(1.0, still)
    pilot.gcs.command(SET_MODE, 1.0, 6.0)
    pilot.fly(1.0, still)
    for gap_s in (0.6, 0.8, 1.1, 1.3):
        pilot.fly(1.0, still)
        pilot.fly(gap_s, None)
    pilot.fly(2.0, still)
    pilot.mode(OFFBOARD)
    messages = pilot.end()
    sent = [m._timestamp for m in of_type(messages, "SET_POSITION_TARGET_LOCAL_NED")]
    gaps = {
        before: after - before for before, after in itertools.pairwise(sent) if after - before > 0.4
    }
    failed = [
        m._timestamp
        for m in of_type(messages, "STATUSTEXT")
        if m.text.startswith("Failsafe activated") and m._timestamp < sent[-1]
    ]
    assert len(failed) == sum(gap > 1.002 for gap in gaps.values()) >= 2
    for at_s in failed:
        begun_s = max(before for before in gaps if before < at_s)
        assert 0.98 <= at_s - begun_s <= 1.09


def test_a_step_over_the_wire(pilot: Pilot) -> None:
    """The bands of low drag of 1 m/s forward, widened by 15 %, at 50 Hz, from reception on."""
    pilot.take_off(489.4 + 6.0)
    pilot.fly(1.0, (0.0, 0.0, 0.0))
    pilot.gcs.command(SET_MODE, 1.0, 6.0)
    pilot.fly(3.0, (0.0, 0.0, 0.0))
    pilot.fly(4.0, (1.0, 0.0, 0.0))
    messages = pilot.end()
    stepped = next(m for m in of_type(messages, "SET_POSITION_TARGET_LOCAL_NED") if m.vx > 0.0)
    start_s = stepped._timestamp
    yaw = next(m for m in of_type(messages, "ATTITUDE") if m._timestamp >= start_s).yaw
    samples = [
        (m._timestamp - start_s, m.vx * math.cos(yaw) + m.vy * math.sin(yaw))
        for m in of_type(messages, "LOCAL_POSITION_NED")
        if 0.0 < m._timestamp - start_s < 4.0
    ]

    def reach(share: float) -> float:
        return next(float(seconds) for seconds, speed in samples if speed >= share)

    steady = [speed for seconds, speed in samples if seconds > 3.0]
    for value, (low, high) in (
        (reach(0.10), (0.20, 0.32)),
        (reach(0.632), (0.64, 0.84)),
        (reach(0.90), (0.94, 1.22)),
        (max(speed for _, speed in samples) - 1.0, (0.10, 0.21)),
        (sum(steady) / len(steady), (0.95, 1.15)),
    ):
        assert low * (1.0 - WIDER) <= value <= high * (1.0 + WIDER)
