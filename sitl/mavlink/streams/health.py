"""Encode how the vehicle is: heartbeat, modes, health, battery."""

from sitl.mavlink.streams.view import View, uint16
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.newer_messages import CurrentEventSequence
from sitl.records.missions import MissionProgress
from sitl.records.sensing import SensorHealth

MAVLINK_VERSION = 3
SENSORS_PRESENT = 0x0300402F  # MAV_SYS_STATUS_SENSOR, these three as a running PX4 showed them
SENSORS_ENABLED = 0x0301402F
SENSORS_HEALTHY = 0x1320C83F
SENSOR_GYRO, SENSOR_ACCELEROMETER, SENSOR_MAGNETOMETER, SENSOR_BAROMETER = 1, 2, 4, 8
SENSOR_GPS = 0x20
SENSOR_ATTITUDE = 0x0800 | 0x200000  # stabilisation and AHRS
SENSOR_POSITION = 0x4000  # horizontal position control
SENSOR_PREARM = 0x10000000
LOAD_PERMILLE = 120  # inside the band that PX4 shows; ours depends on the host
NO_CELL = 65535  # the whole pack stands in the first cell, as PX4 reports one without taps
CURRENT_UNKNOWN = -100  # PX4's -1 A
CHARGE_OK = 1  # MAV_BATTERY_CHARGE_STATE; low, critical and emergency follow
ESTIMATOR_ALL = 1023
ESTIMATOR_ATTITUDE = 1
ESTIMATOR_VERTICAL = 4 | 32  # vertical velocity, absolute height
NO_MISSION_TOTAL = 65535
EVENT_SEQUENCE = 0
EVENTS_RESET = 1  # MAV_EVENT_CURRENT_SEQUENCE_FLAGS: there are none
IN_MISSION_MODE, NOT_IN_MISSION_MODE = 1, 2  # MISSION_CURRENT.mission_mode
STANDARD_MODES = {  # MAV_STANDARD_MODE by the name of our mode
    "POSCTL": 1,
    "ALTCTL": 4,
    "RTL": 5,
    "MISSION": 6,
    "LAND": 7,
    "TAKEOFF": 8,
}


def heartbeat(custom_mode: int, base_mode: int, system_status: int) -> Message:
    """HEARTBEAT of a PX4 quadrotor."""
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_QUADROTOR,
        mavlink.MAV_AUTOPILOT_PX4,
        base_mode,
        custom_mode,
        system_status,
        MAVLINK_VERSION,
    )


def heartbeat_now(view: View) -> Message:
    """HEARTBEAT with the present mode."""
    status = view.status
    return heartbeat(status.custom_mode, status.base_mode, status.system_status)


def component_heartbeat(component_type: int) -> Message:
    """HEARTBEAT of a component that is no autopilot, so that nobody takes it for the vehicle."""
    return mavlink.MAVLink_heartbeat_message(
        component_type,
        mavlink.MAV_AUTOPILOT_INVALID,
        0,
        0,
        mavlink.MAV_STATE_ACTIVE,
        MAVLINK_VERSION,
    )


def sys_status(view: View) -> Message:
    """SYS_STATUS: which sensors are there and healthy, and whether the vehicle can be armed."""
    status = view.status
    healthy = SENSORS_HEALTHY & ~_failed(view.estimate.sensors)
    if not status.attitude_valid:
        healthy &= ~SENSOR_ATTITUDE
    if not status.position_valid:
        healthy &= ~(SENSOR_GPS | SENSOR_POSITION)
    if not status.armable:
        healthy &= ~SENSOR_PREARM
    return mavlink.MAVLink_sys_status_message(
        SENSORS_PRESENT,
        SENSORS_ENABLED,
        healthy,
        LOAD_PERMILLE,
        uint16(view.readings.battery_v * 1e3),
        CURRENT_UNKNOWN,
        round(view.readings.battery * 100.0),
        *(0,) * 6,
    )


def _failed(sensors: SensorHealth) -> int:
    """MAV_SYS_STATUS_SENSOR bits of the sensors that don't read what makes sense."""
    bits = {
        SENSOR_GYRO: sensors.gyro,
        SENSOR_ACCELEROMETER: sensors.accelerometer,
        SENSOR_MAGNETOMETER: sensors.magnetometer,
        SENSOR_BAROMETER: sensors.barometer,
        SENSOR_GPS: sensors.gps,
    }
    return sum(bit for bit, is_healthy in bits.items() if not is_healthy)


def battery_status(view: View) -> Message:
    """BATTERY_STATUS: the pack as a whole, and how urgent its state is."""
    return mavlink.MAVLink_battery_status_message(
        0,
        mavlink.MAV_BATTERY_FUNCTION_ALL,
        mavlink.MAV_BATTERY_TYPE_LIPO,
        2**15 - 1,
        (uint16(view.readings.battery_v * 1e3), *(NO_CELL,) * 9),
        CURRENT_UNKNOWN,
        -1,
        -1,
        round(view.readings.battery * 100.0),
        0,
        CHARGE_OK + view.status.battery_warning,
    )


def extended_sys_state(view: View) -> Message:
    """EXTENDED_SYS_STATE: on the ground, taking off, in the air, landing."""
    return mavlink.MAVLink_extended_sys_state_message(0, view.status.landed_state)


def estimator_status(view: View) -> Message:
    """ESTIMATOR_STATUS: what the estimate is good for, and how far off it may be."""
    flags = ESTIMATOR_ALL
    if not view.status.position_valid:
        flags = ESTIMATOR_ATTITUDE if view.status.attitude_valid else 0
        flags |= ESTIMATOR_VERTICAL if view.status.altitude_valid else 0
    ratios = (0.0,) * 6  # of innovations to what they may be: there is no filter that has any
    return mavlink.MAVLink_estimator_status_message(
        view.time_us, flags, *ratios, *view.estimate.accuracy_m
    )


def current_mode(view: View) -> Message:
    """CURRENT_MODE: what it does and what the user asked for."""
    status = view.status
    return mavlink.MAVLink_current_mode_message(
        STANDARD_MODES.get(status.mode.name, 0),
        status.custom_mode,
        status.intended_mode.custom_mode,
    )


def mission_current(view: View) -> Message:
    """MISSION_CURRENT of the autopilot."""
    return mission_progress(view.mission)


def mission_progress(progress: MissionProgress) -> Message:
    """MISSION_CURRENT: the item that is flown, of how many, and how it goes."""
    return mavlink.MAVLink_mission_current_message(
        progress.sequence,
        progress.total or NO_MISSION_TOTAL,
        progress.state,
        IN_MISSION_MODE if progress.in_mission_mode else NOT_IN_MISSION_MODE,
    )


def system_time(view: View) -> Message:
    """SYSTEM_TIME: vehicle time, and the wall clock that it began at, running with it."""
    return mavlink.MAVLink_system_time_message(view.unix_us, view.time_ms)


def timesync(view: View) -> Message:
    """TIMESYNC that asks the other side for its time."""
    return mavlink.MAVLink_timesync_message(0, view.time_us * 1000)


def ping(view: View) -> Message:
    """PING that asks everybody; numbered by the second of vehicle time."""
    return mavlink.MAVLink_ping_message(view.time_us, view.time_us // 1_000_000, 0, 0)


def current_event_sequence(_view: View) -> Message:
    """CURRENT_EVENT_SEQUENCE: no event so far."""
    return CurrentEventSequence(EVENT_SEQUENCE, EVENTS_RESET)
