"""PX4's simulator interface as messages: what the sensors read goes out, motor commands come in.

Frames and units as PX4 takes them (`SimulatorMavlink.cpp`): FRD, m/s2, rad/s, gauss, hPa; a group
of `fields_updated` counts only as a whole. Vehicle time is PX4's clock.
"""

import math
from typing import NamedTuple

from sitl.frames import geodetic_from_ned
from sitl.mavlink.streams.view import degrees_e7, int16, int32
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.motion import MotorThrusts, Vector3
from sitl.records.sensing import GpsReading, Readings

INERTIAL, MAGNETOMETER, BAROMETER = 0x003F, 0x01C0, 0x1A00  # groups of HIL_SENSOR.fields_updated
ARMED = 0x80  # MAV_MODE_FLAG_SAFETY_ARMED, in HIL_ACTUATOR_CONTROLS.mode
ACCURACY_CM = (90, 178)  # eph, epv: one sigma, as PX4's SIH says of the same noise
FULL_CIRCLE_CDEG = 36000
NO_THRUST: MotorThrusts = (0.0, 0.0, 0.0, 0.0)


class MotorCommand(NamedTuple):
    """HIL_ACTUATOR_CONTROLS, as far as a quadrotor needs it."""

    time_us: int  # PX4's clock: of the sensors that it answers
    thrusts: MotorThrusts
    armed: bool


def hil_sensor(time_us: int, readings: Readings, groups: int) -> Message:
    """HIL_SENSOR of unit 0, which moves PX4's clock to `time_us`."""
    return mavlink.MAVLink_hil_sensor_message(
        time_us,
        *readings.specific_force_frd,
        *readings.rates_frd,
        *readings.field_frd,
        readings.pressure_hpa,
        0.0,  # differential pressure: no airspeed sensor
        readings.pressure_altitude_m,
        readings.temperature_c,
        groups,
        0,
    )


def hil_gps(fix: GpsReading, home: Vector3, unix_us: int) -> Message:
    """HIL_GPS; its time becomes PX4's UTC."""
    latitude, longitude, altitude_m = geodetic_from_ned(fix.position_ned, home)
    north, east, down = fix.velocity_ned
    course_cdeg = round(math.degrees(math.atan2(east, north)) * 100.0) % FULL_CIRCLE_CDEG
    return mavlink.MAVLink_hil_gps_message(
        unix_us,
        fix.fix_type,
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude_m * 1e3),
        *ACCURACY_CM,
        int16(math.hypot(north, east) * 1e2),
        int16(north * 1e2),
        int16(east * 1e2),
        int16(down * 1e2),
        course_cdeg,
        fix.satellites,
    )


def read_motors(message: Message) -> MotorCommand:
    """Read HIL_ACTUATOR_CONTROLS; what is no number between 0 and 1 is brought there."""
    a, b, c, d = (_share(value) for value in message.controls[:4])
    return MotorCommand(message.time_usec, (a, b, c, d), bool(message.mode & ARMED))


def _share(value: float) -> float:
    return 0.0 if math.isnan(value) else min(max(value, 0.0), 1.0)
