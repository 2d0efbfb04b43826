"""What a real PX4 was seen to show, line by line, from the running vehicle on the ground."""

import math
from collections.abc import Iterator

import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.observed.idle import IDLE, LOAD_PERMILLE
from tests.wire.vehicle_process import Client, Vehicle, is_acknowledgement, is_from

pytestmark = pytest.mark.flight
SET_MODE, REQUEST_MESSAGE, ARM = 176, 512, 400
STANDBY, BOOT = 3, 0
MODES = {  # main, sub: custom_mode, base_mode and system_status of a disarmed vehicle
    (1, 0): (0x00010000, 81, BOOT),
    (2, 0): (0x00020000, 81, BOOT),
    (3, 0): (0x00030000, 81, BOOT),
    (5, 0): (0x00050000, 65, BOOT),
    (7, 0): (0x00070000, 81, BOOT),
    (6, 0): (0x00060000, 1, BOOT),  # without setpoints
    (4, 2): (0x02040000, 29, STANDBY),
    (4, 3): (0x03040000, 29, STANDBY),
    (4, 4): (0x04040000, 29, BOOT),
    (4, 5): (0x05040000, 29, BOOT),
    (4, 6): (0x06040000, 29, BOOT),
    (4, 9): (0x09040000, 29, BOOT),
    (4, 8): (0x08040000, 17, BOOT),
}
INVALID = "SET_POSITION_TARGET_LOCAL_NED invalid\t"
FORCE = "SET_POSITION_TARGET_LOCAL_NED force not supported\t"
ALL_IGNORED, VELOCITY, FORCE_BIT = 0xDFF, 0x5C7, 0x200


def frame_text(frame: int) -> str:
    return f"SET_POSITION_TARGET_LOCAL_NED coordinate frame {frame} unsupported\t"


SETPOINTS = [  # target system, frame, type_mask, what is said
    (1, 1, VELOCITY, ""),
    (1, 8, VELOCITY, ""),
    *((1, frame, VELOCITY, frame_text(frame)) for frame in (0, 3, 6, 7, 9, 12, 20, 21)),
    (1, 1, ALL_IGNORED, INVALID),
    (1, 8, ALL_IGNORED, INVALID),
    *((1, 8, VELOCITY | 1 << bit, INVALID) for bit in (3, 4, 5)),
    (1, 1, VELOCITY | 8, ""),  # vx alone ignored
    (1, 1, FORCE_BIT | 0x03F, FORCE),
    (2, 12, VELOCITY, ""),
    (2, 1, ALL_IGNORED, ""),
]


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with Vehicle("-q", "--speed-factor=4") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello()
        vehicle.gcs.wait_for(
            lambda m: is_from(1, "HEARTBEAT")(m) and m.system_status == STANDBY, "readiness"
        )
        yield vehicle.gcs


@pytest.mark.parametrize("numbers", MODES, ids=str)
def test_heartbeat_of_each_mode(client: Client, numbers: tuple[int, int]) -> None:
    client.forget()
    client.command(SET_MODE, 1.0, *map(float, numbers))
    results = [client.wait_for(is_acknowledgement(SET_MODE)).result for _ in range(2)]
    assert results == [0, 0]
    custom_mode, base_mode, status = MODES[numbers]
    shown = client.wait_for(
        lambda m: is_from(1, "HEARTBEAT")(m) and m.custom_mode == custom_mode, hex(custom_mode)
    )
    assert (shown.base_mode, shown.system_status) == (base_mode, status)
    assert (shown.type, shown.autopilot, shown.mavlink_version) == (2, 12, 3)


@pytest.mark.parametrize("name", IDLE)
def test_idle_values(client: Client, name: str) -> None:
    client.command(SET_MODE, 1.0, 4.0, 3.0)
    client.forget()
    message_id = getattr(mavlink, f"MAVLINK_MSG_ID_{name}")
    client.command(REQUEST_MESSAGE, float(message_id))
    shown = client.wait_for(is_from(1, name), name)
    for field, expected in IDLE[name].items():
        value = getattr(shown, field)
        if isinstance(expected, float) and math.isnan(expected):
            assert math.isnan(value), field
        else:
            assert value == expected, field
    if name == "SYS_STATUS":
        low, high = LOAD_PERMILLE
        assert low <= shown.load <= high
    if name == "ATTITUDE_TARGET":
        assert shown.thrust == pytest.approx(0.001, abs=0.0015)
    if name == "HOME_POSITION":
        place = (shown.latitude / 1e7, shown.longitude / 1e7, shown.altitude / 1e3)
        assert place == pytest.approx((47.3977428, 8.5455967, 489.6), rel=0.0, abs=1.5)


@pytest.mark.parametrize(("system", "frame", "mask", "text"), SETPOINTS)
def test_setpoints(client: Client, system: int, frame: int, mask: int, text: str) -> None:
    client.forget()
    numbers = [0.0] * 11
    setpoint = mavlink.MAVLink_set_position_target_local_ned_message(
        0, system, 1, frame, mask, *numbers
    )
    heard = client.ask(setpoint)
    texts = [m for m in heard if m.get_type() == "STATUSTEXT"]
    assert "".join(m.text for m in texts) == text
    assert all(m.severity == 2 for m in texts)
