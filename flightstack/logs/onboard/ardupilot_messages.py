"""Say in MAVLink what ArduPilot's records hold of motion, sensors, outputs and battery."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.onboard.ardupilot_events import heartbeat, landed
from flightstack.logs.onboard.messages import at, make, parameter_values, status_texts
from flightstack.logs.onboard.topics import Floats, Made, Maker, OnboardRecords, Times

EKF_NAMES = ("XKF1", "NKF1", "EKF1")
MOTION = ("PN", "PE", "PD", "VN", "VE", "VD")
UNKNOWN_HEADING = 65_535


def _motion(records: OnboardRecords, times: Times) -> Floats:
    """Return position and velocity of the filter at these times, (n, 6) m, m/s NED."""
    topic = records.topic(*EKF_NAMES)
    return at(times, topic, topic.columns(*MOTION) if topic else np.empty((0, 6)))


def _wrapped(degrees: Floats) -> Floats:
    """Return an angle of 0 to 360 deg in rad, -pi to pi."""
    return np.asarray((np.radians(degrees) + np.pi) % (2 * np.pi) - np.pi)


def _attitude(records: OnboardRecords) -> Made | None:
    topic = records.topic("ATT")
    if topic is None:
        return None
    imu = records.topic("IMU")
    turning = imu.columns("GyrX", "GyrY", "GyrZ") if imu else np.empty((0, 3))
    rates = at(topic.boot_us, imu, turning).T
    roll, pitch = np.radians(topic.column("Roll")), np.radians(topic.column("Pitch"))
    return make(
        "ATTITUDE", topic.boot_us, roll=roll, pitch=pitch, yaw=_wrapped(topic.column("Yaw")),
        rollspeed=rates[0], pitchspeed=rates[1], yawspeed=rates[2],
    )  # fmt: skip


def _quaternions(roll: Floats, pitch: Floats, yaw: Floats) -> Floats:
    """Return quaternions w, x, y, z (n, 4) of angles in rad."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a / 2), np.sin(a / 2)) for a in (roll, pitch, yaw))
    parts = (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
    return np.stack(parts, axis=1)


def _attitude_target(records: OnboardRecords) -> Made | None:
    topic = records.topic("ATT")
    if topic is None or not topic.has("DesRoll", "DesPitch", "DesYaw"):
        return None
    wanted = np.radians(topic.columns("DesRoll", "DesPitch", "DesYaw"))
    return make("ATTITUDE_TARGET", topic.boot_us, q=_quaternions(*wanted.T))


def _local_position(records: OnboardRecords) -> Made | None:
    topic = records.topic(*EKF_NAMES)
    if topic is None:
        return None
    names = ("x", "y", "z", "vx", "vy", "vz")
    columns = dict(zip(names, topic.columns(*MOTION).T, strict=True))
    return make("LOCAL_POSITION_NED", topic.boot_us, **columns)


def _position_target(records: OnboardRecords) -> Made | None:
    """Return what the position controller follows: PSCN, PSCE and PSCD."""
    topic = records.topic("PSCN")
    if topic is None:
        return None
    columns = {}
    axes = (("PSCN", "N", "x"), ("PSCE", "E", "y"), ("PSCD", "D", "z"))
    for name, letter, axis in axes:
        part = records.topic(name)
        wanted = part.columns(f"TP{letter}", f"TV{letter}") if part else np.empty((0, 2))
        columns[axis], columns[f"v{axis}"] = at(topic.boot_us, part, wanted).T
    frame = np.ones(len(topic))
    return make("POSITION_TARGET_LOCAL_NED", topic.boot_us, coordinate_frame=frame, **columns)


def _global_position(records: OnboardRecords) -> Made | None:
    topic = records.topic("POS")
    if topic is None:
        return None
    _, _, _, north, east, down = _motion(records, topic.boot_us).T
    return make(
        "GLOBAL_POSITION_INT", topic.boot_us, lat=topic.column("Lat") * 1e7,
        lon=topic.column("Lng") * 1e7, alt=topic.column("Alt") * 1e3,
        relative_alt=topic.column("RelHomeAlt", "RelAlt") * 1e3,
        vx=north * 100, vy=east * 100, vz=down * 100, hdg=np.full(len(topic), UNKNOWN_HEADING),
    )  # fmt: skip


def _gps(records: OnboardRecords) -> Made | None:
    topic = records.topic("GPS")
    if topic is None:
        return None
    return make(
        "GPS_RAW_INT", topic.boot_us, fix_type=topic.column("Status"),
        lat=topic.column("Lat") * 1e7, lon=topic.column("Lng") * 1e7,
        alt=topic.column("Alt") * 1e3, eph=topic.column("HDop") * 100,
        epv=np.full(len(topic), UNKNOWN_HEADING), vel=topic.column("Spd") * 100,
        cog=topic.column("GCrs") * 100, satellites_visible=topic.column("NSats"),
    )  # fmt: skip


def _system_status(records: OnboardRecords) -> Made | None:
    topic = records.topic("BAT", "CURR")
    if topic is None:
        return None
    remaining = topic.column("RemPct")
    return make(
        "SYS_STATUS", topic.boot_us, voltage_battery=topic.column("Volt") * 1e3,
        current_battery=topic.column("Curr") * 100,
        battery_remaining=np.where(np.isfinite(remaining), remaining, -1),
    )  # fmt: skip


def _channels(records: OnboardRecords, name: str, prefix: str, most: int) -> dict[str, Floats]:
    topic = records.topics[name]
    numbers = [number for number in range(1, most + 1) if topic.has(f"C{number}")]
    return {f"{prefix}{number}_raw": topic.column(f"C{number}") for number in numbers}


def _outputs(records: OnboardRecords) -> Made | None:
    topic = records.topic("RCOU")
    if topic is None:
        return None
    return make("SERVO_OUTPUT_RAW", topic.boot_us, **_channels(records, "RCOU", "servo", 16))


def _remote_control(records: OnboardRecords) -> Made | None:
    topic = records.topic("RCIN")
    if topic is None:
        return None
    channels = _channels(records, "RCIN", "chan", 18)
    count: NDArray[np.int64] = np.full(len(topic), len(channels))
    rssi: NDArray[np.int64] = np.full(len(topic), 255)  # not known
    return make("RC_CHANNELS", topic.boot_us, chancount=count, rssi=rssi, **channels)


def _vibration(records: OnboardRecords) -> Made | None:
    topic = records.topic("VIBE")
    if topic is None:
        return None
    clips = np.nan_to_num(topic.columns("Clip0", "Clip1", "Clip2"))
    clips[:, 0] = np.nan_to_num(topic.column("Clip", "Clip0"))
    return make(
        "VIBRATION", topic.boot_us, vibration_x=topic.column("VibeX"),
        vibration_y=topic.column("VibeY"), vibration_z=topic.column("VibeZ"),
        **{f"clipping_{n}": clips[:, n] for n in range(3)},
    )  # fmt: skip


def _estimator(records: OnboardRecords) -> Made | None:
    topic = records.topic("XKF4", "NKF4", "EKF4")
    if topic is None:
        return None
    names = {"velocity_variance": "SV", "pos_horiz_variance": "SP", "pos_vert_variance": "SH",
             "compass_variance": "SM", "airspeed_variance": "SVT"}  # fmt: skip
    columns = {name: topic.column(field) for name, field in names.items()}
    return make("EKF_STATUS_REPORT", topic.boot_us, flags=topic.column("SS"), **columns)


def _airspeed(records: OnboardRecords) -> Made | None:
    topic = records.topic("ARSP")
    if topic is None:
        return None
    _, _, down, north, east, sinking = _motion(records, topic.boot_us).T
    return make(
        "VFR_HUD", topic.boot_us, airspeed=topic.column("Airspeed"),
        groundspeed=np.hypot(north, east), alt=-down, climb=-sinking,
    )  # fmt: skip


def _version(records: OnboardRecords) -> Made | None:
    topic = records.topic("VER")
    if topic is None or not topic.has("Maj", "Min", "Pat"):
        return None
    first = topic.columns("Maj", "Min", "Pat", "FWT")[:1].astype(np.int64)
    number = (first << np.array([24, 16, 8, 0])).sum(axis=1)
    return make("AUTOPILOT_VERSION", topic.boot_us[:1], flight_sw_version=number)


MAKERS: Mapping[str, Maker] = {
    "ATTITUDE": _attitude,
    "ATTITUDE_TARGET": _attitude_target,
    "AUTOPILOT_VERSION": _version,
    "EKF_STATUS_REPORT": _estimator,
    "EXTENDED_SYS_STATE": landed,
    "GLOBAL_POSITION_INT": _global_position,
    "GPS_RAW_INT": _gps,
    "HEARTBEAT": heartbeat,
    "LOCAL_POSITION_NED": _local_position,
    "PARAM_VALUE": parameter_values,
    "POSITION_TARGET_LOCAL_NED": _position_target,
    "RC_CHANNELS": _remote_control,
    "SERVO_OUTPUT_RAW": _outputs,
    "STATUSTEXT": lambda records: status_texts(records.texts),
    "SYS_STATUS": _system_status,
    "VFR_HUD": _airspeed,
    "VIBRATION": _vibration,
}
