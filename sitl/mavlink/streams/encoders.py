"""Which message is encoded by what: all that can be streamed or requested."""

from collections.abc import Callable, Mapping

from sitl.mavlink.streams import health, identity, motion, sensing
from sitl.mavlink.streams.view import View
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.newer_messages import CurrentEventSequence

Encoder = Callable[[View], Message | None]  # None: not known (yet)

ENCODERS: Mapping[int, Encoder] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: health.heartbeat_now,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: health.sys_status,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: health.system_time,
    mavlink.MAVLINK_MSG_ID_PING: health.ping,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: sensing.gps_raw_int,
    mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: sensing.scaled_pressure,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: motion.attitude,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: motion.attitude_quaternion,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: motion.local_position_ned,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: motion.global_position_int,
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: sensing.servo_output_raw,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: health.mission_current,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: motion.vfr_hud,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: motion.attitude_target,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: motion.position_target_local_ned,
    mavlink.MAVLINK_MSG_ID_HIGHRES_IMU: sensing.highres_imu,
    mavlink.MAVLINK_MSG_ID_TIMESYNC: health.timesync,
    mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION: motion.hil_state_quaternion,
    mavlink.MAVLINK_MSG_ID_ALTITUDE: motion.altitude,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: health.battery_status,
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: health.estimator_status,
    mavlink.MAVLINK_MSG_ID_VIBRATION: sensing.vibration,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: identity.home_position,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: health.extended_sys_state,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: motion.odometry,
    mavlink.MAVLINK_MSG_ID_CURRENT_MODE: health.current_mode,
    CurrentEventSequence.id: health.current_event_sequence,
}
