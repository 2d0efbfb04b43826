"""Where a vehicle truly is, as its simulator tells: HIL_STATE_QUATERNION, dated and checked.

PX4's SIH leaves `time_usec` 0; such a pose is dated by the newest ATTITUDE of the same link. The
origin of the local frame is the first pose, unless a place is given: there the course is laid out.
"""

import math
from typing import Any

from sitl.frames import ned_from_geodetic
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.motion import Quaternion, Vector3, VehicleState

ATTITUDE: int = mavlink.MAVLINK_MSG_ID_ATTITUDE
POSE: int = mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
DEGREE, CM, MG = 1e-7, 1e-2, 9.80665e-3  # units of the message in deg, m, m/s2
UNIT_TOLERANCE = 0.05  # of a quaternion's length


class PoseReader:
    """Makes true states of the messages of one boot of a vehicle."""

    def __init__(self, origin: Vector3 | None) -> None:
        """Take the origin, deg, deg, m AMSL; None: the first pose is on the ground there."""
        self.origin = origin
        self._attitude_us = -1  # of the newest ATTITUDE

    def read(self, message: Any) -> VehicleState | None:
        """Take a message; give the pose that it tells, in the local frame, if it tells one."""
        if message.get_msgId() == ATTITUDE:
            self._attitude_us = message.time_boot_ms * 1000
            return None
        time_us = message.time_usec or self._attitude_us
        orientation = _unit(message.attitude_quaternion)
        if time_us < 0 or orientation is None:
            return None
        place = (message.lat * DEGREE, message.lon * DEGREE, message.alt * 1e-3)
        if self.origin is None:
            self.origin = place
        rates = (message.rollspeed, message.pitchspeed, message.yawspeed)
        return VehicleState(
            time_us,
            ned_from_geodetic(place, self.origin),
            (message.vx * CM, message.vy * CM, message.vz * CM),
            orientation,
            rates if all(map(math.isfinite, rates)) else (0.0, 0.0, 0.0),
            (message.xacc * MG, message.yacc * MG, message.zacc * MG),
        )


def _unit(quaternion: list[float]) -> Quaternion | None:
    """Bring a quaternion to unit length; None where it is none."""
    length = math.sqrt(sum(part * part for part in quaternion))
    if not abs(length - 1.0) < UNIT_TOLERANCE:  # so that NaN is refused, too
        return None
    w, x, y, z = (part / length for part in quaternion)
    return (w, x, y, z)
