"""What a real PX4 was seen doing in OFFBOARD on the ground, off it and back to it.

In lockstep, so the times are the vehicle's; EXTENDED_SYS_STATE is asked for at 10 Hz.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.lockstep_pilot import (
    ACTIVE,
    ARM,
    BEAT_S,
    HOME_AMSL_M,
    SET_MODE,
    STANDBY,
    STILL,
    Heard,
    LockstepPilot,
    Setpoint,
    named,
)
from tests.wire.vehicle_process import Vehicle, is_acknowledgement, is_from, is_text

pytestmark = pytest.mark.flight
OFFBOARD, ON_GROUND, IN_AIR = 0x00060000, 1, 2
TELL, STATE_ID, STATE_US = 511, 245, 100_000  # SET_MESSAGE_INTERVAL of EXTENDED_SYS_STATE
WIDER = 0.15
UP, DOWN = Setpoint((0.0, 0.0, -1.0)), Setpoint((0.0, 0.0, 0.7))
TAKE_OFF, HOLD, MISSION = 22, 0x03040000, 0x04040000
FLY_MISSION = (1.0, 4.0, 4.0)  # DO_SET_MODE


@pytest.fixture
def pilot() -> Iterator[LockstepPilot]:
    """Hand out a vehicle that can be armed, with nobody but a viewer and a silent stream."""
    options = ("-q", "--lockstep", "--speed-factor=0", "--noise=0,0")
    with Vehicle(*options) as vehicle, LockstepPilot(vehicle) as pilot:
        pilot.order(TELL, STATE_ID, STATE_US)
        yield pilot


def is_state(state: int) -> Any:
    return lambda m: is_from(1, "EXTENDED_SYS_STATE")(m) and m.landed_state == state


def is_at(height_m: float) -> Any:
    return lambda m: m.get_type() == "LOCAL_POSITION_NED" and m.z <= -height_m


def beats(heard: list[Heard]) -> set[tuple[int, int, int]]:
    shown = named(heard, "HEARTBEAT")
    return {(beat.custom_mode, beat.base_mode, beat.system_status) for beat in shown}


def is_disarmed(message: Any) -> bool:
    return bool(is_from(1, "HEARTBEAT")(message) and not message.base_mode & 128)


def test_it_is_ready_and_knows_its_home_in_time(pilot: LockstepPilot) -> None:
    """PX4: home some 4 s after boot. Readiness comes sooner here than its 8 s of alignment."""
    heard = pilot.fly(7.0)
    home = next(h for h in heard if is_from(1, "HOME_POSITION")(h.message))
    ready = next(h for h in heard if is_text("Ready for takeoff!")(h.message))
    assert home.time_s <= 4.0 * (1.0 + WIDER) + 2.0  # it is told each two seconds
    assert (ready.message.text, ready.message.severity) == ("Ready for takeoff!\t", 6)
    assert ready.time_s <= 9.0


def test_it_can_be_armed_without_any_ground_station() -> None:
    with Vehicle("-q", "--speed-factor=5") as vehicle:
        vehicle.api.wait_for(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.system_status == STANDBY, "readiness"
        )
        vehicle.api.command(ARM, 1.0)
        assert vehicle.api.wait_for(is_acknowledgement(ARM)).result == 0


def test_armed_and_still_it_stays_on_the_ground_and_disarms(pilot: LockstepPilot) -> None:
    """PX4: 10 s after it was armed, 11.7 s in the heartbeat; the mode stays."""
    pilot.fly_until(is_text("Ready for takeoff!"), "readiness")
    pilot.enter_offboard()
    assert beats(pilot.fly(2.0 * BEAT_S)) == {(OFFBOARD, 17, STANDBY)}
    pilot.order(ARM, 1.0)
    armed_s = pilot.time_s
    heard = pilot.fly(8.0)
    assert {m.landed_state for m in named(heard, "EXTENDED_SYS_STATE")} == {ON_GROUND}
    assert beats(heard[len(heard) // 4 :]) == {(OFFBOARD, 145, ACTIVE)}
    said = pilot.fly_until(is_text("Disarmed by auto preflight disarming"), "disarming")
    assert said.time_s - armed_s == pytest.approx(10.0, abs=0.2)
    beat = pilot.fly_until(is_disarmed, "disarmed")
    assert beat.message.custom_mode == OFFBOARD
    assert 10.0 <= beat.time_s - armed_s <= 11.9


def test_up_and_down_by_velocity(pilot: LockstepPilot) -> None:
    """PX4: in the air 2 s after arming, 5 m after 8.3 s, disarmed 2.8 s after landing.

    It was seen at 1 Hz in the air and disarmed: so much sooner it may have been so.
    """
    pilot.fly_until(is_text("Ready for takeoff!"), "readiness")
    pilot.enter_offboard()
    pilot.order(ARM, 1.0)
    armed_s = pilot.time_s
    pilot.fly(1.1)  # as there
    off_s = pilot.fly_until(is_state(IN_AIR), "air", UP).time_s - armed_s
    five_s = pilot.fly_until(is_at(5.0), "5 m", UP).time_s - armed_s
    down = pilot.fly_until(is_state(ON_GROUND), "ground", DOWN)
    disarmed = pilot.fly_until(is_disarmed, "disarmed", DOWN)
    assert 2.0 - BEAT_S <= off_s <= 2.0 * (1.0 + WIDER)
    assert 8.3 * (1.0 - WIDER) <= five_s <= 8.3 * (1.0 + WIDER)
    assert 2.8 - BEAT_S <= disarmed.time_s - down.time_s <= 2.8 * (1.0 + WIDER)
    assert disarmed.message.custom_mode == OFFBOARD


def test_take_off_to_a_height_above_the_sea(pilot: LockstepPilot) -> None:
    """PX4: home + 6 m gave 6 to 7 m."""
    pilot.fly_until(is_text("Ready for takeoff!"), "readiness")
    pilot.order(ARM, 1.0)
    nan = float("nan")
    pilot.order(TAKE_OFF, *[nan] * 6, HOME_AMSL_M + 6.0)
    pilot.fly_until(is_state(IN_AIR), "air", STILL)
    pilot.fly_until(lambda m: is_from(1, "HEARTBEAT")(m) and m.custom_mode == HOLD, "HOLD")
    place = named(pilot.fly(3.0), "GLOBAL_POSITION_INT")[-1]
    assert 6.0 * (1.0 - WIDER) <= place.relative_alt / 1e3 <= 7.0 * (1.0 + WIDER)


def test_a_mission_is_not_started_at_once_after_its_upload_in_flight(pilot: LockstepPilot) -> None:
    """PX4: refused within some 100 ms; wait 1.5 s."""
    pilot.take_off_in_offboard(3.0)
    here = named(pilot.fly(0.5), "GLOBAL_POSITION_INT")[-1]
    numbers = (0.0, 2.0, 0.0, float("nan"), here.lat, here.lon, 3.0)
    pilot.gcs.send(mavlink.MAVLink_mission_count_message(1, 1, 1, 0))
    pilot.gcs.send(mavlink.MAVLink_mission_item_int_message(1, 1, 0, 6, 16, 1, 1, *numbers))
    pilot.gcs.command(SET_MODE, *FLY_MISSION)
    heard = pilot.fly(BEAT_S + 0.1)
    assert [ack.type for ack in named(heard, "MISSION_ACK")] == [0]
    assert [ack.result for ack in named(heard, "COMMAND_ACK")] == [0, 1]
    said = "".join(text.text for text in named(heard, "STATUSTEXT") if text.severity == 2)
    assert "Switching to Mission is currently not available\t" in said
    assert beats(heard) == {(OFFBOARD, 145, ACTIVE)}
    pilot.fly(0.4)
    pilot.gcs.command(SET_MODE, *FLY_MISSION)
    heard = pilot.fly(2.0 * BEAT_S)
    assert [ack.result for ack in named(heard, "COMMAND_ACK")] == [0, 0]
    assert (MISSION, 157, ACTIVE) in beats(heard)
