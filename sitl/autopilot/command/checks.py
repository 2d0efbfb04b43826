"""Which modes can be armed, and which can run now."""

from enum import IntEnum
from typing import NamedTuple

from sitl.records.modes import Mode
from sitl.records.sensing import SensorHealth

NAMES = {
    Mode.MANUAL: "Manual",
    Mode.ALTCTL: "Altitude",
    Mode.POSCTL: "Position",
    Mode.ACRO: "Acro",
    Mode.STABILIZED: "Stabilized",
    Mode.OFFBOARD: "Offboard",
    Mode.TAKEOFF: "Takeoff",
    Mode.HOLD: "Hold",
    Mode.MISSION: "Mission",
    Mode.RTL: "Return",
    Mode.LAND: "Land",
    Mode.FOLLOW: "Follow Target",
    Mode.PRECLAND: "Precision Landing",
    Mode.TERMINATION: "Termination",
}

ARMABLE = {Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD, Mode.MISSION, Mode.ALTCTL, Mode.POSCTL}
NEEDS_POSITION = {*ARMABLE - {Mode.ALTCTL}, Mode.RTL}
NEEDS_STICKS = {Mode.ALTCTL, Mode.POSCTL}


class Battery(IntEnum):
    """How empty the battery is."""

    FINE = 0
    LOW = 1
    CRITICAL = 2
    EMERGENCY = 3


class Health(NamedTuple):
    """What the checks and the failsafes look at."""

    attitude_valid: bool = False
    position_valid: bool = False
    altitude_valid: bool = False
    offboard_available: bool = False  # setpoints younger than COM_OF_LOSS_T
    offboard_by_attitude: bool = False  # those setpoints need no position
    sticks_available: bool = False  # MANUAL_CONTROL younger than COM_RC_LOSS_T
    sticks_lost: bool = False  # there were sticks, and they have become silent
    ground_station_lost: bool = False  # likewise its heartbeat, for COM_DL_LOSS_T
    mission_available: bool = False  # uploaded, and within the fence
    mission_failed: bool = False  # and no other was uploaded since
    fence_breached: bool = False  # and GF_ACTION is set
    battery: Battery = Battery.FINE
    sensors: SensorHealth = SensorHealth()
    settled: bool = True  # the estimate, after boot


def can_run(mode: Mode, health: Health) -> bool:
    """Say whether a mode may be switched to in flight.

    There is nobody to follow: the mode that needs one can't run. Manual, acro and stabilised flight
    are not offered.
    """
    if mode is Mode.LAND:  # always accepted: the way out
        return True
    if mode is Mode.ALTCTL:
        return health.attitude_valid and health.altitude_valid and health.sticks_available
    if mode is Mode.OFFBOARD and health.offboard_by_attitude:
        return health.attitude_valid and health.offboard_available
    located = health.attitude_valid and health.position_valid and health.altitude_valid
    supplied = {
        Mode.OFFBOARD: health.offboard_available,
        Mode.MISSION: health.mission_available,
        Mode.POSCTL: health.sticks_available,
    }
    return mode in NEEDS_POSITION and located and supplied.get(mode, True)


def can_arm(mode: Mode, health: Health) -> bool:
    """Say whether the vehicle may be armed in a mode."""
    sensors = health.sensors
    sound = sensors.gyro and sensors.accelerometer and sensors.magnetometer and sensors.barometer
    fit = sound and health.battery < Battery.LOW and not health.fence_breached
    return mode in ARMABLE and fit and health.settled and can_run(mode, health)
