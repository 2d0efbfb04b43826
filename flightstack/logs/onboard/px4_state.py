"""Say in MAVLink what PX4 is: mode, arming, failsafe, landed or not, version."""

import numpy as np

from flightstack.logs.onboard.messages import (
    ACTIVE,
    ARMED,
    CRITICAL,
    DISARMED,
    IN_AIR,
    ON_GROUND,
    STANDBY,
    make,
)
from flightstack.logs.onboard.topics import Made, OnboardRecords
from flightstack.px4_modes import AutoMode, MainMode, PositionMode

PX4 = 12  # MAV_AUTOPILOT
BYTEWISE_PARAMETERS = 1 << 4  # MAV_PROTOCOL_CAPABILITY
ARMING_STATE_ARMED = 2  # vehicle_status.arming_state
GENERIC, QUADROTOR, FIXED_WING, ROVER = 0, 2, 1, 10  # MAV_TYPE
OLD_TYPES = {1: QUADROTOR, 2: FIXED_WING, 3: ROVER}  # vehicle_status.vehicle_type


def _mode(main: MainMode, sub: int = 0) -> int:
    return main << 16 | sub << 24


# vehicle_status.nav_state: custom_mode, as PX4's px4_custom_mode.h pairs them
NAV_STATES = {
    0: _mode(MainMode.MANUAL),
    1: _mode(MainMode.ALTCTL),
    2: _mode(MainMode.POSCTL),
    3: _mode(MainMode.AUTO, AutoMode.MISSION),
    4: _mode(MainMode.AUTO, AutoMode.LOITER),
    5: _mode(MainMode.AUTO, AutoMode.RTL),
    6: _mode(MainMode.POSCTL, PositionMode.SLOW),
    8: _mode(MainMode.ALTITUDE_CRUISE),
    10: _mode(MainMode.ACRO),
    12: _mode(MainMode.AUTO, AutoMode.LAND),  # descending without a position
    13: _mode(MainMode.TERMINATION),
    14: _mode(MainMode.OFFBOARD),
    15: _mode(MainMode.STABILIZED),
    17: _mode(MainMode.AUTO, AutoMode.TAKEOFF),
    18: _mode(MainMode.AUTO, AutoMode.LAND),
    19: _mode(MainMode.AUTO, AutoMode.FOLLOW),
    20: _mode(MainMode.AUTO, AutoMode.PRECLAND),
    21: _mode(MainMode.POSCTL, PositionMode.ORBIT),
    22: _mode(MainMode.AUTO, AutoMode.VTOL_TAKEOFF),
}


def heartbeat(records: OnboardRecords) -> Made | None:
    """Return HEARTBEAT of each vehicle_status; None without any."""
    status = records.topic("vehicle_status")
    if status is None:
        return None
    armed = status.column("arming_state") == ARMING_STATE_ARMED
    kinds = status.column("system_type")
    if not np.isfinite(kinds).all():
        old = status.column("vehicle_type").tolist()
        kinds = np.array([OLD_TYPES.get(kind, QUADROTOR) for kind in old], dtype=np.float64)
    modes = [NAV_STATES.get(int(state), 0) for state in status.column("nav_state").tolist()]
    return make(
        "HEARTBEAT", status.boot_us, autopilot=np.full(len(status), PX4), type=kinds,
        base_mode=np.where(armed, ARMED, DISARMED), custom_mode=np.array(modes),
        system_status=np.where(
            status.column("failsafe") > 0, CRITICAL, np.where(armed, ACTIVE, STANDBY)
        ),
    )  # fmt: skip


def landed(records: OnboardRecords) -> Made | None:
    """Return EXTENDED_SYS_STATE of each vehicle_land_detected; None without any."""
    topic = records.topic("vehicle_land_detected")
    if topic is None:
        return None
    states = np.where(topic.column("landed") > 0, ON_GROUND, IN_AIR)
    return make("EXTENDED_SYS_STATE", topic.boot_us, landed_state=states)


def version(records: OnboardRecords) -> Made:
    """Return AUTOPILOT_VERSION, once."""
    release = records.versions.get("ver_sw_release", 0)
    first = min(int(topic.boot_us[0]) for topic in records.topics.values())
    return make(
        "AUTOPILOT_VERSION", np.array([first]), capabilities=np.array([BYTEWISE_PARAMETERS]),
        flight_sw_version=np.array([release if isinstance(release, int) else 0]),
    )  # fmt: skip
