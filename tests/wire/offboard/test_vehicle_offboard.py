"""A flight over the wire: arming, take-off, offboard, its loss and return, refusals, landing."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.vehicle_process import (
    Client,
    Vehicle,
    is_acknowledgement,
    is_from,
    is_text,
)

pytestmark = pytest.mark.flight
SPEED_FACTOR = 4.0
SETPOINT_S = 0.025  # wall time: 10 Hz for the vehicle
NAN = float("nan")
HOLD, TAKEOFF, OFFBOARD, RTL, LAND = 0x03040000, 0x02040000, 0x00060000, 0x05040000, 0x06040000
ACCEPTED, TEMPORARILY_REJECTED = 0, 1
IN_AIR = 2
HOLDS_M, WIDER = (2.1, 2.9), 0.15


class Pilot:
    """Wait for things while a stream of velocities goes out."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.velocity_body: tuple[float, float, float] | None = None
        self.time_ms = 0
        self._sent_s = self._hello_s = 0.0

    def wait_for(self, condition: Callable[[Any], bool], what: str, seconds: float) -> Any:
        """Wait at most some seconds of vehicle time."""
        begun_ms = None
        for message in self.client.messages(60.0):
            self._stream()
            if message.get_type() == "ATTITUDE":
                self.time_ms = message.time_boot_ms
                begun_ms = begun_ms or self.time_ms
                assert self.time_ms < begun_ms + seconds * 1000, f"no {what} in {seconds} s"
            if condition(message):
                return message
        raise AssertionError(f"no {what}")

    def beat(self, custom_mode: int, base_mode: int, status: int) -> None:
        """Wait for a HEARTBEAT that shows all three."""

        def shown(message: Any) -> bool:
            if not is_from(1, "HEARTBEAT")(message):
                return False
            values = (message.custom_mode, message.base_mode, message.system_status)
            return values == (custom_mode, base_mode, status)

        self.wait_for(shown, f"mode {custom_mode:#010x} {base_mode} {status}", 15.0)

    def text(self, beginning: str, seconds: float = 10.0) -> int:
        """Wait for a text; the vehicle time at which it came, ms."""
        self.wait_for(is_text(beginning), beginning, seconds)
        return self.time_ms

    def command(self, number: int, *params: float, results: list[int]) -> None:
        """Send a command and expect these acknowledgements."""
        self.client.command(number, *params)
        for result in results:
            answer = self.wait_for(is_acknowledgement(number), f"answer to {number}", 4.0)
            assert answer.result == result

    def fly(self, seconds: float) -> None:
        """Let vehicle time pass."""
        end_ms = self.time_ms + seconds * 1000
        self.wait_for(
            lambda m: m.get_type() == "ATTITUDE" and m.time_boot_ms >= end_ms, "time", seconds + 1
        )

    def _stream(self) -> None:
        now_s = time.monotonic()
        if now_s - self._hello_s > 1.0:
            self.client.say_hello()
            self._hello_s = now_s
        if self.velocity_body is None or now_s - self._sent_s < SETPOINT_S:
            return
        self._sent_s = now_s
        velocity = (0.0, 0.0, 0.0, *self.velocity_body, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.client.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                self.time_ms, 1, 1, 8, 0x5C7, *velocity
            )
        )


@pytest.fixture
def pilot() -> Iterator[Pilot]:
    with Vehicle("-q", "--noise=0,0", f"--speed-factor={SPEED_FACTOR}") as vehicle:
        vehicle.wait_until_up()
        yield Pilot(vehicle.gcs)


def height_m(pilot: Pilot) -> float:
    """Metres above home."""
    place = pilot.wait_for(is_from(1, "GLOBAL_POSITION_INT"), "position", 1.0)
    return float(place.relative_alt / 1e3)


def take_off(pilot: Pilot) -> None:
    """PX4: it holds at 2.1 to 2.9 m."""
    pilot.beat(HOLD, 29, 3)
    pilot.command(400, 1, results=[ACCEPTED])
    pilot.beat(HOLD, 157, 4)
    pilot.command(22, *[NAN] * 7, results=[ACCEPTED])
    pilot.text("Using default takeoff altitude: 2.5 m\t")
    pilot.text("Takeoff detected\t")
    pilot.beat(TAKEOFF, 157, 4)
    pilot.wait_for(
        lambda m: m.get_type() == "EXTENDED_SYS_STATE" and m.landed_state == IN_AIR, "air", 15.0
    )
    pilot.beat(HOLD, 157, 4)
    low, high = HOLDS_M
    assert low * (1.0 - WIDER) <= height_m(pilot) <= high * (1.0 + WIDER)


def test_a_flight_in_offboard_its_loss_and_its_return(pilot: Pilot) -> None:
    take_off(pilot)
    pilot.command(176, 1, 6, results=[ACCEPTED, TEMPORARILY_REJECTED])
    pilot.text("Switching to Offboard is currently not available")
    pilot.velocity_body = (0.0, 0.0, 0.0)
    pilot.fly(1.0)
    pilot.command(176, 1, 6, results=[ACCEPTED, ACCEPTED])
    pilot.beat(OFFBOARD, 145, 4)

    pilot.velocity_body = (1.0, 0.0, 0.0)
    pilot.fly(4.0)
    place = pilot.wait_for(is_from(1, "LOCAL_POSITION_NED"), "position", 1.0)
    assert place.x > 2.0
    assert abs(place.y) < 0.3
    echo = pilot.wait_for(is_from(1, "POSITION_TARGET_LOCAL_NED"), "echo", 1.0)
    assert (echo.coordinate_frame, echo.type_mask & 0x3F) == (1, 7)
    assert (echo.vx, echo.vy) == pytest.approx((1.0, 0.0), abs=0.05)

    pilot.velocity_body = None
    stopped_ms = pilot.time_ms
    failed_ms = pilot.text("Failsafe activated")
    assert 850 <= failed_ms - stopped_ms <= 1400  # 1.0 s after the last, at 10 Hz, one client's lag
    pilot.beat(RTL, 157, 5)
    pilot.velocity_body = (0.0, 0.0, 0.0)
    pilot.beat(OFFBOARD, 145, 4)

    pilot.velocity_body = (NAN, 0.0, 0.0)  # brakes, and stays
    pilot.fly(2.0)
    pilot.beat(OFFBOARD, 145, 4)


def test_refusals_in_the_air_and_a_landing(pilot: Pilot) -> None:
    take_off(pilot)
    for mode, name in ((3, "Position"), (2, "Altitude"), (1, "Manual")):
        pilot.command(176, 1, mode, results=[ACCEPTED, TEMPORARILY_REJECTED])
        pilot.text(f"Switching to {name} is currently not available"[:50])
    pilot.command(400, 0, results=[TEMPORARILY_REJECTED])
    pilot.text("Disarming denied: not landed")
    pilot.command(21, results=[ACCEPTED])
    pilot.text("Landing at current position")
    pilot.beat(LAND, 157, 4)
    pilot.text("Landing detected", 20.0)
    pilot.text("Disarmed by landing")
    pilot.beat(HOLD, 29, 3)
    assert abs(height_m(pilot)) < 1.0  # as far as it knows


def test_a_kill_in_the_air_stops_at_once(pilot: Pilot) -> None:
    take_off(pilot)
    pilot.command(400, 0, 21196, results=[ACCEPTED])
    servos = pilot.wait_for(is_from(1, "SERVO_OUTPUT_RAW"), "outputs", 1.0)
    assert servos.servo1_raw == 900
    pilot.beat(HOLD, 29, 3)
