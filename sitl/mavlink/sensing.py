"""Encode what the sensors read and the outputs drive.

The receiver and the barometer are ideal: they read the truth. The inertial unit reads what the
autopilot is given.
"""

import math

from sitl.frames import rotate_inverse
from sitl.mavlink.dialect import Message, mavlink
from sitl.mavlink.view import View, degrees_e7, int16, int32, uint16

MAGNETIC_FIELD_NED = (0.215, 0.011, 0.433)  # gauss, World Magnetic Model at PX4's default home
SATELLITES = 10
GPS_FIX_3D = 3
HDOP, VDOP = 0.7, 1.1
GPS_ACCURACY_M = (0.9, 1.78)  # horizontal, vertical; what PX4's simulated receiver claims
GPS_SPEED_ACCURACY_M_S = 0.25
IMU_FIELDS = 0b1_1011_1111_1111  # all but differential pressure
OUTPUTS = 16
OUTPUT_UNUSED_US = 900
SEA_LEVEL_HPA = 1013.25  # International Standard Atmosphere, with the next three
SEA_LEVEL_C = 15.0
LAPSE_C_M = 0.0065
PRESSURE_EXPONENT = 5.25588


def gps_raw_int(view: View) -> Message:
    """GPS_RAW_INT."""
    latitude, longitude, altitude_m = view.true_geodetic
    north, east, _ = view.truth.velocity_ned
    return mavlink.MAVLink_gps_raw_int_message(
        view.time_us,
        GPS_FIX_3D,
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude_m * 1e3),
        uint16(HDOP * 1e2),
        uint16(VDOP * 1e2),
        uint16(math.hypot(north, east) * 1e2),
        uint16(math.degrees(math.atan2(east, north)) % 360.0 * 1e2),
        SATELLITES,
        int32(altitude_m * 1e3),
        int32(GPS_ACCURACY_M[0] * 1e3),
        int32(GPS_ACCURACY_M[1] * 1e3),
        int32(GPS_SPEED_ACCURACY_M_S * 1e3),
    )


def highres_imu(view: View) -> Message:
    """HIGHRES_IMU."""
    estimate = view.estimate
    altitude_m = view.true_geodetic[2]
    return mavlink.MAVLink_highres_imu_message(
        view.time_us,
        *estimate.specific_force_frd,
        *estimate.rates_frd,
        *rotate_inverse(estimate.q_ned_frd, MAGNETIC_FIELD_NED),
        pressure_hpa(altitude_m),
        0.0,
        altitude_m,
        temperature_c(altitude_m),
        IMU_FIELDS,
    )


def scaled_pressure(view: View) -> Message:
    """SCALED_PRESSURE of the barometer."""
    altitude_m = view.true_geodetic[2]
    return mavlink.MAVLink_scaled_pressure_message(
        view.time_ms, pressure_hpa(altitude_m), 0.0, int16(temperature_c(altitude_m) * 1e2)
    )


def vibration(view: View) -> Message:
    """VIBRATION: a simulated frame does not shake."""
    return mavlink.MAVLink_vibration_message(view.time_us, 0.0, 0.0, 0.0, 0, 0, 0)


def servo_output_raw(view: View) -> Message:
    """SERVO_OUTPUT_RAW: four motors, the other outputs unused."""
    motors = view.status.actuator_outputs
    unused = (OUTPUT_UNUSED_US,) * (OUTPUTS - len(motors))
    return mavlink.MAVLink_servo_output_raw_message(view.time_us & 0xFFFFFFFF, 0, *motors, *unused)


def pressure_hpa(altitude_m: float) -> float:
    """Give the static pressure of the standard atmosphere (troposphere)."""
    ratio = 1.0 - LAPSE_C_M * altitude_m / (SEA_LEVEL_C + 273.15)
    return float(SEA_LEVEL_HPA * max(0.0, min(2.0, ratio)) ** PRESSURE_EXPONENT)


def temperature_c(altitude_m: float) -> float:
    """Give the temperature of the standard atmosphere."""
    return SEA_LEVEL_C - LAPSE_C_M * altitude_m
