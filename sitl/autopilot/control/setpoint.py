"""What the modes request of the position controller."""

import math
from typing import NamedTuple

from sitl.records.motion import Vector3
from sitl.records.vehicle import NAN_VECTOR


class Setpoint(NamedTuple):
    """A trajectory setpoint in local NED; NaN where a number is not given."""

    position_ned: Vector3 = NAN_VECTOR  # m
    velocity_ned: Vector3 = NAN_VECTOR  # m/s
    acceleration_ned: Vector3 = NAN_VECTOR  # m/s2, feed-forward
    yaw_rad: float = math.nan
    yaw_rate_rad_s: float = math.nan  # feed-forward


IDLE = Setpoint(acceleration_ned=(0.0, 0.0, 100.0))  # rotors idle: as PX4 shows it on the ground


def level(setpoint: Setpoint) -> Setpoint:
    """Keep the vertical part, and stay level: for when nobody knows the horizontal motion."""
    return setpoint._replace(
        position_ned=(math.nan, math.nan, setpoint.position_ned[2]),
        velocity_ned=(math.nan, math.nan, setpoint.velocity_ned[2]),
        acceleration_ned=(0.0, 0.0, setpoint.acceleration_ned[2]),
    )
