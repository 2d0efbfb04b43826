"""What can be made to fail, and how: MAVLink's FAILURE_UNIT and FAILURE_TYPE."""

import math
from enum import IntEnum
from typing import NamedTuple


class FailureUnit(IntEnum):
    """FAILURE_UNIT, as far as this vehicle has the unit.

    MAVLink has no unit for a camera: the sensor that looks, SENSOR_VIO, stands for it.
    """

    GYRO = 0
    ACCELEROMETER = 1
    MAGNETOMETER = 2
    BAROMETER = 3
    GPS = 4
    CAMERA = 6
    BATTERY = 100
    MOTOR = 101
    MAVLINK_SIGNAL = 105


class FailureType(IntEnum):
    """FAILURE_TYPE."""

    OK = 0
    OFF = 1  # no output
    STUCK = 2  # the last output for ever
    GARBAGE = 3  # chance
    WRONG = 4  # consistently off
    SLOW = 5  # at a tenth of the rate
    DELAYED = 6  # by half a second
    INTERMITTENT = 7  # there for a second, gone for a second


class Failure(NamedTuple):
    """One failure to inject."""

    unit: FailureUnit
    type: FailureType
    instance: int = 0  # of several motors, from 1; 0 means all


ALL_TYPES = frozenset(FailureType)
SENSORS = frozenset(
    {
        FailureUnit.GYRO,
        FailureUnit.ACCELEROMETER,
        FailureUnit.MAGNETOMETER,
        FailureUnit.BAROMETER,
        FailureUnit.GPS,
    }
)
SUPPORTED = {
    **dict.fromkeys(SENSORS, ALL_TYPES),
    FailureUnit.CAMERA: ALL_TYPES - {FailureType.WRONG},
    FailureUnit.BATTERY: ALL_TYPES,
    FailureUnit.MOTOR: ALL_TYPES,
    # Nothing that was said before is said again, nor anything else that makes sense.
    FailureUnit.MAVLINK_SIGNAL: ALL_TYPES - {FailureType.STUCK, FailureType.WRONG},
}
UNITS, TYPES = [float(unit) for unit in FailureUnit], [float(kind) for kind in FailureType]
MOTORS = 4
PERIOD_US = 1_000_000  # of an intermittent failure: this long there, this long gone
DELAY_US = 500_000  # by which a delayed unit is late
SLOWER = 10  # how many outputs a slow unit drops for each that it gives


def parse_failure(unit: float, kind: float, instance: float) -> Failure | None:
    """Read the parameters of MAV_CMD_INJECT_FAILURE; None for what this vehicle can't do."""
    number = 0 if math.isnan(instance) else instance
    if unit not in UNITS or kind not in TYPES:
        return None
    failure = Failure(FailureUnit(int(unit)), FailureType(int(kind)), round(min(number, 255.0)))
    supported = failure.type in SUPPORTED[failure.unit]
    exists = 0 <= failure.instance <= (MOTORS if failure.unit is FailureUnit.MOTOR else 1)
    return failure if supported and exists else None


def is_gone(since_us: int, time_us: int) -> bool:
    """Whether an intermittent failure that began at `since_us` shows at `time_us`."""
    return (time_us - since_us) // PERIOD_US % 2 == 0
