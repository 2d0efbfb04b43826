"""Which modes can be armed, and which can run now."""

from typing import NamedTuple

from sitl.modes import Mode

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

ARMABLE = {Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD, Mode.MISSION}
NEEDS_POSITION = {Mode.HOLD, Mode.TAKEOFF, Mode.OFFBOARD, Mode.RTL, Mode.MISSION}


class Health(NamedTuple):
    """What the checks look at."""

    attitude_valid: bool = False
    position_valid: bool = False
    altitude_valid: bool = False
    offboard_available: bool = False  # setpoints younger than COM_OF_LOSS_T
    mission_available: bool = False  # uploaded, and within the fence
    fence_breached: bool = False  # and GF_ACTION is set


def can_run(mode: Mode, health: Health) -> bool:
    """Say whether a mode may be switched to in flight.

    There are no sticks and nobody to follow: the modes that need them can't run.
    """
    if mode is Mode.LAND:  # always accepted: the way out
        return True
    located = health.attitude_valid and health.position_valid and health.altitude_valid
    if mode is Mode.OFFBOARD:
        return located and health.offboard_available
    if mode is Mode.MISSION:
        return located and health.mission_available
    return mode in NEEDS_POSITION and located


def can_arm(mode: Mode, health: Health) -> bool:
    """Say whether the vehicle may be armed in a mode."""
    return mode in ARMABLE and can_run(mode, health) and not health.fence_breached
