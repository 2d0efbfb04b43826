"""Encode what the sensors read and the outputs drive."""

import math

from sitl.frames import geodetic_from_ned
from sitl.mavlink.streams.view import View, degrees_e7, int16, int32, uint16
from sitl.mavlink.wire.dialect import Message, mavlink

HDOP, VDOP = 0.7, 1.1
GPS_ACCURACY_M = (0.9, 1.78)  # horizontal, vertical; what PX4's simulated receiver claims
GPS_SPEED_ACCURACY_M_S = 0.25
IMU_FIELDS = 0b1_1011_1111_1111  # all but differential pressure
OUTPUTS = 16
OUTPUT_UNUSED_US = 900


def gps_raw_int(view: View) -> Message:
    """GPS_RAW_INT."""
    gps = view.readings.gps
    latitude, longitude, altitude_m = geodetic_from_ned(gps.position_ned, view.status.home)
    north, east, _ = gps.velocity_ned
    return mavlink.MAVLink_gps_raw_int_message(
        gps.time_us,
        gps.fix_type,
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude_m * 1e3),
        uint16(HDOP * 1e2),
        uint16(VDOP * 1e2),
        uint16(math.hypot(north, east) * 1e2),
        uint16(math.degrees(math.atan2(east, north)) % 360.0 * 1e2),
        gps.satellites,
        int32(altitude_m * 1e3),
        int32(GPS_ACCURACY_M[0] * 1e3),
        int32(GPS_ACCURACY_M[1] * 1e3),
        int32(GPS_SPEED_ACCURACY_M_S * 1e3),
    )


def highres_imu(view: View) -> Message:
    """HIGHRES_IMU."""
    readings = view.readings
    return mavlink.MAVLink_highres_imu_message(
        view.time_us,
        *readings.specific_force_frd,
        *readings.rates_frd,
        *readings.field_frd,
        readings.pressure_hpa,
        0.0,
        readings.pressure_altitude_m,
        readings.temperature_c,
        IMU_FIELDS,
    )


def scaled_pressure(view: View) -> Message:
    """SCALED_PRESSURE of the barometer."""
    readings = view.readings
    return mavlink.MAVLink_scaled_pressure_message(
        view.time_ms, readings.pressure_hpa, 0.0, int16(readings.temperature_c * 1e2)
    )


def vibration(view: View) -> Message:
    """VIBRATION: a simulated frame does not shake."""
    return mavlink.MAVLink_vibration_message(view.time_us, 0.0, 0.0, 0.0, 0, 0, 0)


def servo_output_raw(view: View) -> Message:
    """SERVO_OUTPUT_RAW: four motors, the other outputs unused."""
    motors = view.status.actuator_outputs
    unused = (OUTPUT_UNUSED_US,) * (OUTPUTS - len(motors))
    return mavlink.MAVLink_servo_output_raw_message(view.time_us & 0xFFFFFFFF, 0, *motors, *unused)
