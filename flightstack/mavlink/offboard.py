"""Write velocity setpoints: yaw-aligned body frame, forward-right-down, and a yaw rate."""

import math

from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Message
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT

VELOCITY_AND_YAW_RATE = 0x5C7  # type_mask: ignores position, acceleration and yaw
TIME_WRAP_MS = 1 << 32

Velocities = tuple[float, float, float, float]  # vx, vy, vz m/s; yaw rate rad/s, clockwise
STILL: Velocities = (0.0, 0.0, 0.0, 0.0)


def velocity_setpoint(system_id: int, stamp_us: int, velocities: Velocities) -> Message:
    """Build the setpoint that answers the camera image of this stamp; raises ValueError on NaN."""
    if not all(map(math.isfinite, velocities)):
        raise ValueError(f"velocities: not finite: {velocities}")
    forward, right, down, yaw_rate = velocities
    return common.MAVLink_set_position_target_local_ned_message(
        time_boot_ms=stamp_us // 1000 % TIME_WRAP_MS,
        target_system=system_id,
        target_component=AUTOPILOT_COMPONENT,
        coordinate_frame=common.MAV_FRAME_BODY_NED,
        type_mask=VELOCITY_AND_YAW_RATE,
        x=0.0,
        y=0.0,
        z=0.0,
        vx=forward,
        vy=right,
        vz=down,
        afx=0.0,
        afy=0.0,
        afz=0.0,
        yaw=0.0,
        yaw_rate=yaw_rate,
    )
