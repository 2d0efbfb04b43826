"""Frames of the simulator: NWU/FLU inside pybullet, NED/FRD everywhere else, and geodesy.

pybullet's world is NWU (x north, y west, z up) and its bodies are FLU. Both differ from NED and
FRD by the same half turn about x, so one sign flip converts vectors, and quaternions likewise.
Quaternions here are (w, x, y, z); pybullet's own order is (x, y, z, w).
"""

import math

from sitl.records.motion import Quaternion, Vector3

EARTH_RADIUS_M = 6371000.0  # PX4 src/lib/geo CONSTANTS_RADIUS_OF_EARTH
GRAVITY_M_S2 = 9.80665  # PX4 CONSTANTS_ONE_G
HOME: Vector3 = (47.397742, 8.545594, 489.4)  # deg, deg, m AMSL of the local origin; PX4's default


def flip(vector: Vector3) -> Vector3:
    """Convert NED <-> NWU, and FRD <-> FLU: its own inverse."""
    return (vector[0], -vector[1], -vector[2])


def to_bullet_quaternion(q_ned_frd: Quaternion) -> tuple[float, float, float, float]:
    """Convert (w, x, y, z) NED<-FRD to pybullet's (x, y, z, w) NWU<-FLU."""
    w, x, y, z = q_ned_frd
    return (x, -y, -z, w)


def from_bullet_quaternion(q_xyzw: tuple[float, float, float, float]) -> Quaternion:
    """Convert pybullet's (x, y, z, w) NWU<-FLU to (w, x, y, z) NED<-FRD."""
    x, y, z, w = q_xyzw
    return (w, x, -y, -z)


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """Rotate `v` by `q`: with q_ned_frd, FRD into NED."""
    w, x, y, z = q
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


def rotate_inverse(q: Quaternion, v: Vector3) -> Vector3:
    """Rotate `v` by the inverse of `q`: with q_ned_frd, NED into FRD."""
    w, x, y, z = q
    tx = 2.0 * (z * v[1] - y * v[2])
    ty = 2.0 * (x * v[2] - z * v[0])
    tz = 2.0 * (y * v[0] - x * v[1])
    return (
        v[0] + w * tx - y * tz + z * ty,
        v[1] + w * ty - z * tx + x * tz,
        v[2] + w * tz - x * ty + y * tx,
    )


def quaternion_from_euler(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """Compose the (w, x, y, z) quaternion of the aerospace sequence yaw, pitch, roll."""
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def euler_from_quaternion(q: Quaternion) -> Vector3:
    """Roll, pitch, yaw (rad) of a (w, x, y, z) quaternion, aerospace sequence."""
    w, x, y, z = q
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    return (roll, pitch, yaw_of(q))


def yaw_of(q: Quaternion) -> float:
    """Heading (rad, clockwise from north seen from above) of a (w, x, y, z) quaternion."""
    w, x, y, z = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def wrap_pi(angle_rad: float) -> float:
    """Wrap an angle into (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def geodetic_from_ned(position_ned: Vector3, home: Vector3) -> Vector3:
    """Latitude, longitude (deg), altitude AMSL (m) of a local position; spherical, as PX4's map."""
    latitude, longitude, altitude = home
    cos_latitude = math.cos(math.radians(latitude))
    return (
        latitude + math.degrees(position_ned[0] / EARTH_RADIUS_M),
        longitude + math.degrees(position_ned[1] / (EARTH_RADIUS_M * cos_latitude)),
        altitude - position_ned[2],
    )


def ned_from_geodetic(point: Vector3, home: Vector3) -> Vector3:
    """Local position (m) of latitude, longitude (deg), altitude AMSL (m): the inverse."""
    latitude, longitude, altitude = home
    cos_latitude = math.cos(math.radians(latitude))
    return (
        math.radians(point[0] - latitude) * EARTH_RADIUS_M,
        math.radians(point[1] - longitude) * EARTH_RADIUS_M * cos_latitude,
        altitude - point[2],
    )
