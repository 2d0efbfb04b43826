"""Frames of the companion side: NED and FRD, yaw-only rotations, Euler angles.

The simulator has its own such file: shared code would let one sign error cancel itself.
"""

import math

import numpy as np
from numpy.typing import NDArray


def ned_from_body(
    vector_frd: tuple[float, float, float], yaw_rad: float
) -> tuple[float, float, float]:
    """Turn a yaw-aligned body vector (MAV_FRAME_BODY_NED) into NED by the heading alone."""
    cos_yaw, sin_yaw = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y, z = vector_frd
    return (cos_yaw * x - sin_yaw * y, sin_yaw * x + cos_yaw * y, z)


def body_from_ned(
    vector_ned: tuple[float, float, float], yaw_rad: float
) -> tuple[float, float, float]:
    """Turn a NED vector into the yaw-aligned body frame: the inverse of `ned_from_body`."""
    return ned_from_body(vector_ned, -yaw_rad)


def wrap_pi(angle_rad: float) -> float:
    """Wrap an angle into (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def rotation_ned_frd(attitude_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) that turns body axes FRD into NED, of roll, pitch and yaw (3,)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude_rad), np.sin(attitude_rad)
    return np.array(
        [
            [cp * cy, sr * sp * cy - cr * sy, cr * sp * cy + sr * sy],
            [cp * sy, sr * sp * sy + cr * cy, cr * sp * sy - sr * cy],
            [-sp, sr * cp, cr * cp],
        ]
    )
