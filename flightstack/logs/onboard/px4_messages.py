"""Say in MAVLink what PX4's topics hold, as its own MAVLink module would; old field names, too."""

from collections.abc import Mapping

import numpy as np

from flightstack.logs.onboard.messages import at, euler, make, parameter_values, status_texts
from flightstack.logs.onboard.px4_state import heartbeat, landed, version
from flightstack.logs.onboard.topics import Floats, Made, Maker, OnboardRecords, Times

MAX_OUTPUT_SHARE = 2.0  # outputs up to here are shares, above they are pulses in microseconds
IDLE_US, RANGE_US = 1000, 1000  # a share of 0 and of 1 as a pulse


def _rates(records: OnboardRecords, times: Times) -> Floats:
    topic = records.topic("vehicle_angular_velocity")
    return at(times, topic, topic.column("xyz") if topic else np.empty((0, 3)))


def _attitude(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_attitude")
    if topic is None or not topic.has("q"):
        return None
    roll, pitch, yaw = euler(topic.column("q")).T
    rates = _rates(records, topic.boot_us)
    if topic.has("rollspeed", "pitchspeed", "yawspeed"):
        rates = topic.columns("rollspeed", "pitchspeed", "yawspeed")
    names = ("rollspeed", "pitchspeed", "yawspeed")
    speeds = dict(zip(names, rates.T, strict=True))
    return make("ATTITUDE", topic.boot_us, roll=roll, pitch=pitch, yaw=yaw, **speeds)


def _attitude_target(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_attitude_setpoint")
    if topic is None:
        return None
    rates = records.topic("vehicle_rates_setpoint")
    turning = rates.columns("roll", "pitch", "yaw") if rates else np.empty((0, 3))
    names = ("body_roll_rate", "body_pitch_rate", "body_yaw_rate")
    wanted = dict(zip(names, at(topic.boot_us, rates, turning).T, strict=True))
    thrust = topic.column("thrust_body")
    up = -thrust[:, 2] if thrust.ndim == 2 else thrust
    return make("ATTITUDE_TARGET", topic.boot_us, q=topic.column("q_d"), thrust=up, **wanted)


def _local_position(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_local_position")
    if topic is None:
        return None
    columns = {name: topic.column(name) for name in ("x", "y", "z", "vx", "vy", "vz")}
    return make("LOCAL_POSITION_NED", topic.boot_us, **columns)


def _position_target(records: OnboardRecords) -> Made | None:
    """Return what the position controller follows: in OFFBOARD what the companion commanded."""
    topic = records.topic("vehicle_local_position_setpoint", "trajectory_setpoint")
    if topic is None:
        return None
    if topic.has("velocity"):
        names = ("x", "y", "z", "vx", "vy", "vz")
        wanted = np.hstack([topic.column("position"), topic.column("velocity")])
    else:
        names = ("x", "y", "z", "vx", "vy", "vz")
        wanted = topic.columns(*names)
    columns = dict(zip(names, wanted.T, strict=True))
    return make(
        "POSITION_TARGET_LOCAL_NED", topic.boot_us, coordinate_frame=np.ones(len(topic)),
        yaw=topic.column("yaw"), yaw_rate=topic.column("yawspeed"), **columns,
    )  # fmt: skip


def _degrees_e7(values: Floats) -> Floats:
    """Return an angle in 1e-7 deg: newer logs hold degrees, older ones this already."""
    known = np.abs(values[np.isfinite(values)])
    return values * 1e7 if not len(known) or known.max() <= 360 else values


def _global_position(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_global_position")
    if topic is None:
        return None
    local = records.topic("vehicle_local_position")
    motion = local.columns("z", "vx", "vy", "vz") if local else np.empty((0, 4))
    down, vx, vy, vz = at(topic.boot_us, local, motion).T
    return make(
        "GLOBAL_POSITION_INT", topic.boot_us, lat=_degrees_e7(topic.column("lat")),
        lon=_degrees_e7(topic.column("lon")), alt=topic.column("alt") * 1e3,
        relative_alt=-down * 1e3, vx=vx * 100, vy=vy * 100, vz=vz * 100,
        hdg=np.full(len(topic), 65_535),
    )  # fmt: skip


def _gps(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_gps_position", "sensor_gps")
    if topic is None:
        return None
    height = topic.column("altitude_msl_m") * 1e3 if topic.has("altitude_msl_m") else None
    return make(
        "GPS_RAW_INT", topic.boot_us, fix_type=topic.column("fix_type"),
        lat=_degrees_e7(topic.column("latitude_deg", "lat")),
        lon=_degrees_e7(topic.column("longitude_deg", "lon")),
        alt=topic.column("alt") if height is None else height,
        eph=topic.column("hdop") * 100, epv=topic.column("vdop") * 100,
        vel=topic.column("vel_m_s") * 100, cog=np.degrees(topic.column("cog_rad")) % 360 * 100,
        satellites_visible=topic.column("satellites_used"),
        h_acc=topic.column("eph") * 1e3, v_acc=topic.column("epv") * 1e3,
    )  # fmt: skip


def _system_status(records: OnboardRecords) -> Made | None:
    topic = records.topic("battery_status")
    if topic is None:
        return None
    remaining = topic.column("remaining")
    percent = np.where(np.isfinite(remaining) & (remaining >= 0), np.ceil(remaining * 100), -1)
    return make(
        "SYS_STATUS", topic.boot_us, voltage_battery=topic.column("voltage_v") * 1e3,
        current_battery=topic.column("current_a") * 100, battery_remaining=percent,
    )  # fmt: skip


def _outputs(records: OnboardRecords) -> Made | None:
    """Return pulses: of the outputs, or, where these are none, of the motors' shares."""
    topic = records.topic("actuator_outputs", "actuator_motors")
    if topic is None:
        return None
    values = topic.column("output", "control")
    if values.ndim != 2:
        return None
    known = values[np.isfinite(values)]
    if not len(known) or known.max() <= MAX_OUTPUT_SHARE:
        motors = records.topic("actuator_motors")
        topic, values = (topic, values) if motors is None else (motors, motors.column("control"))
        values = IDLE_US + RANGE_US * values  # not a number where there is no motor: 0
    columns = {f"servo{n + 1}_raw": values[:, n] for n in range(min(values.shape[1], 16))}
    return make("SERVO_OUTPUT_RAW", topic.boot_us, **columns)


def _remote_control(records: OnboardRecords) -> Made | None:
    topic = records.topic("input_rc")
    if topic is None or topic.column("values").ndim != 2:
        return None
    values = topic.column("values")
    columns = {f"chan{n + 1}_raw": values[:, n] for n in range(min(values.shape[1], 18))}
    count, rssi = topic.column("channel_count"), topic.column("rssi")
    return make("RC_CHANNELS", topic.boot_us, chancount=count, rssi=rssi, **columns)


def _vibration(records: OnboardRecords) -> Made | None:
    topic = records.topic("vehicle_imu_status")
    if topic is None:
        return None
    clipping = topic.column("accel_clipping")
    clips = clipping.T if clipping.ndim == 2 else np.zeros((3, len(topic)))
    return make(
        "VIBRATION", topic.boot_us, vibration_x=topic.column("delta_angle_coning_metric"),
        vibration_y=topic.column("gyro_vibration_metric"),
        vibration_z=topic.column("accel_vibration_metric"),
        **{f"clipping_{n}": clips[n] for n in range(3)},
    )  # fmt: skip


def _estimator(records: OnboardRecords) -> Made | None:
    topic = records.topic("estimator_status")
    if topic is None:
        return None
    return make(
        "ESTIMATOR_STATUS", topic.boot_us, flags=topic.column("solution_status_flags"),
        vel_ratio=topic.column("vel_test_ratio"), pos_horiz_ratio=topic.column("pos_test_ratio"),
        pos_vert_ratio=topic.column("hgt_test_ratio"), tas_ratio=topic.column("tas_test_ratio"),
        mag_ratio=topic.column("mag_test_ratio", "hdg_test_ratio"),
        hagl_ratio=topic.column("hagl_test_ratio"),
        pos_horiz_accuracy=topic.column("pos_horiz_accuracy"),
        pos_vert_accuracy=topic.column("pos_vert_accuracy"),
    )  # fmt: skip


def _airspeed(records: OnboardRecords) -> Made | None:
    topic = records.topic("airspeed_validated", "airspeed")
    if topic is None:
        return None
    local = records.topic("vehicle_local_position")
    motion = local.columns("z", "vx", "vy", "vz") if local else np.empty((0, 4))
    down, vx, vy, vz = at(topic.boot_us, local, motion).T
    speed = topic.column("calibrated_airspeed_m_s", "indicated_airspeed_m_s")
    ground = np.hypot(vx, vy)
    columns = {"airspeed": speed, "groundspeed": ground, "alt": -down, "climb": -vz}
    return make("VFR_HUD", topic.boot_us, **columns)


def _home(records: OnboardRecords) -> Made | None:
    topic = records.topic("home_position")
    if topic is None:
        return None
    return make(
        "HOME_POSITION", topic.boot_us, latitude=_degrees_e7(topic.column("lat")),
        longitude=_degrees_e7(topic.column("lon")), altitude=topic.column("alt") * 1e3,
        x=topic.column("x"), y=topic.column("y"), z=topic.column("z"),
    )  # fmt: skip


MAKERS: Mapping[str, Maker] = {
    "ATTITUDE": _attitude,
    "ATTITUDE_TARGET": _attitude_target,
    "AUTOPILOT_VERSION": version,
    "ESTIMATOR_STATUS": _estimator,
    "EXTENDED_SYS_STATE": landed,
    "GLOBAL_POSITION_INT": _global_position,
    "GPS_RAW_INT": _gps,
    "HEARTBEAT": heartbeat,
    "HOME_POSITION": _home,
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
