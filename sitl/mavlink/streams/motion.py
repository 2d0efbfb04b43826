"""Encode where the vehicle is and where its controllers want it: the fast streams."""

import math

from sitl.mavlink.streams.view import View, degrees_e7, int16, int32, uint16
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.motion import Vector3, VehicleState

NO_ROTATION = (0.0, 0.0, 0.0, 0.0)  # repr_offset_q: none
UNKNOWN_COVARIANCE = (math.nan,) * 21
FULL_QUALITY = 100  # ODOMETRY.quality, percent


FIRST_POSITION_US = 700_000  # a running PX4 v1.17.0 sent the first one then, 1.5 s at the latest


def attitude(view: View) -> Message:
    """ATTITUDE."""
    return mavlink.MAVLink_attitude_message(view.time_ms, *view.euler_rad, *view.estimate.rates_frd)


def attitude_quaternion(view: View) -> Message:
    """ATTITUDE_QUATERNION, w first."""
    estimate = view.estimate
    return mavlink.MAVLink_attitude_quaternion_message(
        view.time_ms, *estimate.q_ned_frd, *estimate.rates_frd, NO_ROTATION
    )


def local_position_ned(view: View) -> Message | None:
    """LOCAL_POSITION_NED, from soon after the boot: it does not say that there is a position."""
    estimate = view.estimate
    if view.time_us < FIRST_POSITION_US:
        return None
    return mavlink.MAVLink_local_position_ned_message(
        view.time_ms, *estimate.position_ned, *estimate.velocity_ned
    )


def global_position_int(view: View) -> Message | None:
    """GLOBAL_POSITION_INT, once the position is known."""
    if not view.estimate.position_valid:
        return None
    latitude, longitude, altitude = view.geodetic
    north, east, down = view.estimate.velocity_ned
    return mavlink.MAVLink_global_position_int_message(
        view.time_ms,
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude * 1e3),
        int32(view.height_above_home_m * 1e3),
        int16(north * 1e2),
        int16(east * 1e2),
        int16(down * 1e2),
        uint16(view.heading_deg * 1e2),
    )


def odometry(view: View) -> Message | None:
    """ODOMETRY with pose and velocity in local NED, as PX4's estimator reports them."""
    estimate = view.estimate
    if not estimate.position_valid:
        return None
    return mavlink.MAVLink_odometry_message(
        view.time_us,
        mavlink.MAV_FRAME_LOCAL_NED,
        mavlink.MAV_FRAME_LOCAL_NED,
        *estimate.position_ned,
        estimate.q_ned_frd,
        *estimate.velocity_ned,
        *estimate.rates_frd,
        UNKNOWN_COVARIANCE,
        UNKNOWN_COVARIANCE,
        0,
        mavlink.MAV_ESTIMATOR_TYPE_AUTOPILOT,
        FULL_QUALITY,
    )


def altitude(view: View) -> Message | None:
    """ALTITUDE; terrain and clearance are unknown."""
    if not view.estimate.altitude_valid:
        return None
    amsl_m = view.geodetic[2]
    return mavlink.MAVLink_altitude_message(
        view.time_us,
        amsl_m,
        amsl_m,
        -view.estimate.position_ned[2],
        view.height_above_home_m,
        math.nan,
        math.nan,
    )


def vfr_hud(view: View) -> Message:
    """VFR_HUD; there is no airspeed sensor."""
    north, east, down = view.estimate.velocity_ned
    throttle = view.status.throttle if view.status.armed else 0.0
    return mavlink.MAVLink_vfr_hud_message(
        math.nan,
        math.hypot(north, east),
        int16(view.heading_deg),
        uint16(throttle * 1e2),
        view.geodetic[2],
        -down,
    )


def position_target_local_ned(view: View) -> Message:
    """POSITION_TARGET_LOCAL_NED: what the position controller follows, always in local NED."""
    setpoint = view.setpoint
    return mavlink.MAVLink_position_target_local_ned_message(
        view.time_ms,
        mavlink.MAV_FRAME_LOCAL_NED,
        setpoint.type_mask,
        *setpoint.position_ned,
        *setpoint.velocity_ned,
        *setpoint.acceleration_ned,
        setpoint.yaw_rad,
        setpoint.yaw_rate_rad_s,
    )


def attitude_target(view: View) -> Message:
    """ATTITUDE_TARGET: what the attitude and rate controllers follow."""
    setpoint = view.setpoint
    return mavlink.MAVLink_attitude_target_message(
        view.time_ms, 0, setpoint.q_ned_frd, *setpoint.rates_frd, setpoint.thrust
    )


def hil_state_quaternion(view: View) -> Message:
    """HIL_STATE_QUATERNION: the truth, for whoever judges the flight."""
    return true_state(view.time_us, view.truth, view.true_geodetic)


def true_state(time_us: int, truth: VehicleState, place: Vector3) -> Message:
    """HIL_STATE_QUATERNION of a true state at a place: latitude, longitude (deg), altitude (m)."""
    latitude, longitude, altitude_m = place
    return mavlink.MAVLink_hil_state_quaternion_message(
        time_us,
        truth.q_ned_frd,
        *truth.rates_frd,
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude_m * 1e3),
        *(int16(speed * 1e2) for speed in truth.velocity_ned),
        0,
        0,
        *(int16(force / 9.80665 * 1e3) for force in truth.specific_force_frd),
    )
