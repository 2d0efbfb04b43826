"""What the messages of a vehicle on the ground show: what a running PX4 showed."""

import math
from typing import Any

import pytest

from sitl.frames import quaternion_from_euler
from sitl.mavlink.streams import health, identity
from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.view import View
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, split, wrap
from sitl.records.modes import Mode
from tests.observed.idle import IDLE
from tests.unit.sitl.mavlink.fakes import ECHO, FakeVehicle

OURS: dict[str, dict[str, Any]] = {  # beside what was seen: places of the fake, and the like
    "HEARTBEAT": {
        "type": 2,
        "autopilot": 12,
        "mavlink_version": 3,
        "custom_mode": 0x03040000,
        "base_mode": 29,
        "system_status": 3,
    },
    "GPS_RAW_INT": {"lat": 473977428, "lon": 85455967, "alt": 489600},
    "BATTERY_STATUS": {"id": 0, "battery_remaining": 100},
    "SERVO_OUTPUT_RAW": {"port": 0},
    "ATTITUDE_TARGET": {"thrust": pytest.approx(0.001)},
    "VFR_HUD": {"heading": 0, "throttle": 0},
    "HOME_POSITION": {"latitude": 473977428, "longitude": 85455967, "altitude": 489600},
    "GLOBAL_POSITION_INT": {"lat": 473977428, "relative_alt": 0, "hdg": 0},
    "CURRENT_MODE": {"custom_mode": 0x03040000, "intended_custom_mode": 0x03040000},
    "TIMESYNC": {"tc1": 0, "ts1": 2_004_000_000},
    "PING": {"target_system": 0, "target_component": 0},
    "ODOMETRY": {"frame_id": 1, "child_frame_id": 1, "estimator_type": 8},
}
ON_GROUND = {name: IDLE.get(name, {}) | OURS.get(name, {}) for name in IDLE.keys() | OURS.keys()}


def encode(name: str, vehicle: FakeVehicle) -> Any:
    """Encode a message, send it through its packet, and decode it."""
    message = ENCODERS[getattr(mavlink, f"MAVLINK_MSG_ID_{name}")](View(vehicle))
    if message is None:
        return None
    (received,) = split(wrap(pack(message), sequence=0, system=1, component=1))
    assert received.message.get_type() == name
    return received.message


@pytest.mark.parametrize("name", sorted(ON_GROUND))
def test_on_the_ground(name: str) -> None:
    vehicle = FakeVehicle()
    vehicle.time_us = 2_004_000
    fields = encode(name, vehicle).to_dict()
    expected = ON_GROUND[name]
    shown = {field: fields[field] for field in expected}
    nan_fields = {f for f, v in expected.items() if isinstance(v, float) and math.isnan(v)}
    assert all(math.isnan(shown[field]) for field in nan_fields)
    assert {f: v for f, v in shown.items() if f not in nan_fields} == {
        f: v for f, v in expected.items() if f not in nan_fields
    }


def turned_and_moving() -> FakeVehicle:
    vehicle = FakeVehicle()
    vehicle.time_us = 1_500_000
    q = quaternion_from_euler(0.1, -0.2, -math.pi / 2)
    vehicle.estimate = vehicle.estimate._replace(
        position_ned=(10.0, -20.0, -3.0), velocity_ned=(1.0, 2.0, -0.5), q_ned_frd=q
    )
    vehicle.state = vehicle.state._replace(
        position_ned=(10.5, -20.0, -3.0), velocity_ned=(0.0, -2.0, 0.5), q_ned_frd=q
    )
    gps = vehicle.readings.gps._replace(
        position_ned=(10.25, -20.0, -3.5), velocity_ned=(0.0, -2.1, 0.5)
    )
    vehicle.readings = vehicle.readings._replace(gps=gps)
    return vehicle


def test_attitude_and_heading() -> None:
    vehicle = turned_and_moving()
    attitude = encode("ATTITUDE", vehicle)
    assert attitude.time_boot_ms == 1500
    assert (attitude.roll, attitude.pitch, attitude.yaw) == pytest.approx((0.1, -0.2, -math.pi / 2))
    assert encode("VFR_HUD", vehicle).heading == 270
    assert encode("GLOBAL_POSITION_INT", vehicle).hdg == 27000


def test_position_is_the_estimate_gps_the_receivers_and_ground_truth_true() -> None:
    vehicle = turned_and_moving()
    local = encode("LOCAL_POSITION_NED", vehicle)
    assert (local.x, local.y, local.z) == (10.0, -20.0, -3.0)
    assert (local.vx, local.vy, local.vz) == (1.0, 2.0, -0.5)
    position = encode("GLOBAL_POSITION_INT", vehicle)
    assert (position.vx, position.vy, position.vz) == (100, 200, -50)
    assert (position.alt, position.relative_alt) == (492600, 3000)
    gps, truth = encode("GPS_RAW_INT", vehicle), encode("HIL_STATE_QUATERNION", vehicle)
    half_metre_e7 = 0.5 / 6371000.0 * 180.0 / math.pi * 1e7
    assert truth.lat - position.lat == pytest.approx(half_metre_e7, abs=1.0)
    assert gps.lat - position.lat == pytest.approx(half_metre_e7 / 2, abs=1.0)
    assert gps.alt - truth.alt == 500
    assert (gps.vel, gps.cog) == (210, 27000)
    assert (truth.vx, truth.vy, truth.vz) == (0, -200, 50)


def test_throttle_shows_only_when_armed() -> None:
    vehicle = FakeVehicle()
    vehicle.autopilot.change(throttle=0.53)
    assert encode("VFR_HUD", vehicle).throttle == 0
    vehicle.autopilot.change(armed=True)
    assert encode("VFR_HUD", vehicle).throttle == 53


def test_position_messages_wait_for_a_position() -> None:
    vehicle = FakeVehicle()
    vehicle.time_us = 1_000_000
    vehicle.estimate = vehicle.estimate._replace(position_valid=False)
    for name in ("GLOBAL_POSITION_INT", "ODOMETRY"):
        assert encode(name, vehicle) is None
    assert encode("LOCAL_POSITION_NED", vehicle) is not None  # as PX4: it says nothing of that
    vehicle.autopilot.change(home_valid=False)
    assert encode("HOME_POSITION", vehicle) is None


def test_health_follows_estimate_and_arming_checks() -> None:
    vehicle = FakeVehicle()
    vehicle.autopilot.change(armable=False, position_valid=False, attitude_valid=False)
    lost = 0x1320C83F & ~encode("SYS_STATUS", vehicle).onboard_control_sensors_health
    assert lost == 0x10000000 | 0x20 | 0x4000 | 0x800 | 0x200000
    assert encode("ESTIMATOR_STATUS", vehicle).flags == 4 | 32


@pytest.mark.parametrize(
    ("sensor", "bit"),
    [("gyro", 1), ("accelerometer", 2), ("magnetometer", 4), ("barometer", 8), ("gps", 0x20)],
)
def test_a_failed_sensor_shows_in_its_health_bit(sensor: str, bit: int) -> None:
    vehicle = FakeVehicle()
    sensors = vehicle.estimate.sensors._replace(**{sensor: False})
    vehicle.estimate = vehicle.estimate._replace(sensors=sensors)
    assert encode("SYS_STATUS", vehicle).onboard_control_sensors_health == 0x1320C83F & ~bit


def test_readings_are_sent_as_they_are() -> None:
    vehicle = FakeVehicle()
    imu, air = encode("HIGHRES_IMU", vehicle), encode("SCALED_PRESSURE", vehicle)
    assert (imu.xmag, imu.zmag) == pytest.approx((0.2, 0.4))
    assert imu.abs_pressure == air.press_abs == pytest.approx(955.8)
    assert (imu.pressure_alt, air.temperature) == (pytest.approx(489.6), 1180)


def test_a_failsafe_shows_in_current_mode() -> None:
    vehicle = FakeVehicle()
    mode = Mode.POSCTL
    vehicle.autopilot.change(
        mode=mode, custom_mode=mode.custom_mode, intended_mode=Mode.OFFBOARD, failsafe=True
    )
    current = encode("CURRENT_MODE", vehicle)
    assert (current.standard_mode, current.custom_mode) == (1, 0x00030000)
    assert current.intended_custom_mode == 0x00060000


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e30])
@pytest.mark.parametrize("message_id", sorted(ENCODERS))
def test_absurd_states_never_raise(message_id: int, value: float) -> None:
    vehicle = FakeVehicle()
    absurd = (value, value, value)
    vehicle.estimate = vehicle.estimate._replace(position_ned=absurd, velocity_ned=absurd)
    vehicle.state = vehicle.state._replace(
        position_ned=absurd, velocity_ned=absurd, specific_force_frd=absurd
    )
    vehicle.autopilot.change(throttle=value)
    message = ENCODERS[message_id](View(vehicle))
    assert len(pack(message).payload) >= 1


def test_version_says_px4_and_what_it_can() -> None:
    version = identity.autopilot_version(3)
    assert version.flight_sw_version & 0xFF == 255
    assert version.flight_sw_version >> 16 >= 0x010F
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
    assert any(version.uid2)


def test_available_modes_are_numbered_and_nameable() -> None:
    modes = identity.available_modes(0)
    assert [mode.mode_index for mode in modes] == list(range(1, len(Mode) + 1))
    assert {mode.number_modes for mode in modes} == {len(Mode)}
    assert {mode.custom_mode for mode in modes} == {mode.custom_mode for mode in Mode}
    named = {m.custom_mode: m.mode_name for m in modes if m.standard_mode == 0}
    assert named[0x03040000] == "Hold"
    assert named[0x00060000] == "Offboard"
    assert all(named.values())
    assert identity.available_modes(99) == []
    assert [mode.mode_index for mode in identity.available_modes(2)] == [2]


def test_protocol_version_is_mavlink_2() -> None:
    packed = identity.protocol_version()
    assert packed.message_id == 300
    assert packed.payload == bytes([200, 0, 100, 0, 200])


def test_components_cannot_be_taken_for_the_vehicle() -> None:
    beat = health.component_heartbeat(mavlink.MAV_TYPE_CAMERA)
    assert beat.autopilot == mavlink.MAV_AUTOPILOT_INVALID


@pytest.mark.parametrize(
    ("field", "index", "bit"),
    [
        *(("position_ned", axis, f"{name}_IGNORE") for axis, name in enumerate("XYZ")),
        *(("velocity_ned", axis, f"V{name}_IGNORE") for axis, name in enumerate("XYZ")),
        *(("acceleration_ned", axis, f"A{name}_IGNORE") for axis, name in enumerate("XYZ")),
        ("yaw_rad", None, "YAW_IGNORE"),
        ("yaw_rate_rad_s", None, "YAW_RATE_IGNORE"),
    ],
)
def test_what_is_not_followed_is_masked_out(field: str, index: int | None, bit: str) -> None:
    zero = (0.0, 0.0, 0.0)
    followed = ECHO._replace(position_ned=zero, velocity_ned=zero, acceleration_ned=zero)
    vehicle = FakeVehicle()
    vehicle.autopilot.setpoint_echo = followed
    assert encode("POSITION_TARGET_LOCAL_NED", vehicle).type_mask == 0
    hole: Any = math.nan if index is None else (*zero[:index], math.nan, *zero[index + 1 :])
    vehicle.autopilot.setpoint_echo = followed._replace(**{field: hole})
    expected = getattr(mavlink, f"POSITION_TARGET_TYPEMASK_{bit}")
    assert encode("POSITION_TARGET_LOCAL_NED", vehicle).type_mask == expected
