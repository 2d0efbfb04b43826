"""Which modes can be armed, and which can run now, by the table of modes."""

from enum import IntEnum
from typing import NamedTuple

from sitl.autopilot.command.mode_table import (
    MODES,
    OFFBOARD_BY_ATTITUDE,
    Acceptance,
    ModeRules,
    Needs,
)
from sitl.records.modes import Mode
from sitl.records.sensing import SensorHealth


class BatteryLevel(IntEnum):
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
    battery: BatteryLevel = BatteryLevel.FINE
    sensors: SensorHealth = SensorHealth()
    settled: bool = True  # the estimate, after boot


def rules_of(mode: Mode, health: Health) -> ModeRules:
    """Give a mode's row of the table."""
    rules = MODES[mode]
    by_attitude = rules.needs.setpoints and health.offboard_by_attitude
    return OFFBOARD_BY_ATTITUDE if by_attitude else rules


def is_known(needs: Needs, health: Health) -> bool:
    """Say whether the estimate gives what is needed of it."""
    return (
        (health.attitude_valid or not needs.attitude)
        and (health.position_valid or not needs.position)
        and (health.altitude_valid or not needs.altitude)
    )


def can_run(mode: Mode, health: Health) -> bool:
    """Say whether a mode may be switched to in flight."""
    rules = rules_of(mode, health)
    if rules.accepted is not Acceptance.WITH_ITS_NEEDS:
        return rules.accepted is Acceptance.ALWAYS
    needs = rules.needs
    return (
        is_known(needs, health)
        and (health.offboard_available or not needs.setpoints)
        and (health.sticks_available or not needs.sticks)
        and (health.mission_available or not needs.mission)
    )


def can_arm(mode: Mode, health: Health) -> bool:
    """Say whether the vehicle may be armed in a mode."""
    sensors = health.sensors
    sound = sensors.gyro and sensors.accelerometer and sensors.magnetometer and sensors.barometer
    fit = sound and health.battery < BatteryLevel.LOW and not health.fence_breached
    return MODES[mode].armable and fit and health.settled and can_run(mode, health)
