"""What the sensors read, and what the autopilot believes by them."""

import math
from typing import NamedTuple

from sitl.records.motion import Quaternion, Vector3


class SensorHealth(NamedTuple):
    """Which sensors give readings that make sense."""

    gyro: bool = True
    accelerometer: bool = True
    magnetometer: bool = True
    barometer: bool = True
    gps: bool = True


class GpsReading(NamedTuple):
    """One fix of the satellite receiver, its position already in the local frame."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    fix_type: int  # GPS_FIX_TYPE
    satellites: int


class Readings(NamedTuple):
    """What each sensor read last, with its noise and bias."""

    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2
    field_frd: Vector3  # gauss
    pressure_hpa: float
    pressure_altitude_m: float  # AMSL, of the standard atmosphere
    temperature_c: float
    gps: GpsReading
    health: SensorHealth
    battery: float = 1.0  # charge left, 0..1
    battery_v: float = 16.2  # of the whole pack


class Estimate(NamedTuple):
    """What the autopilot believes; never the truth itself."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    q_ned_frd: Quaternion
    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2
    attitude_valid: bool
    position_valid: bool  # horizontal position and velocity
    altitude_valid: bool
    sensors: SensorHealth = SensorHealth()
    battery: float = 1.0  # charge left, 0..1
    accuracy_m: tuple[float, float] = (0.0, 0.0)  # standard deviation, horizontal and vertical
    settled: bool = True  # long enough after boot to take off by it
    z_deriv_m_s: float = math.nan  # rate of the estimated position, down; NaN: that is the velocity


NO_ESTIMATE = Estimate(
    time_us=0,
    position_ned=(0.0, 0.0, 0.0),
    velocity_ned=(0.0, 0.0, 0.0),
    q_ned_frd=(1.0, 0.0, 0.0, 0.0),
    rates_frd=(0.0, 0.0, 0.0),
    specific_force_frd=(0.0, 0.0, 0.0),
    attitude_valid=False,
    position_valid=False,
    altitude_valid=False,
)
