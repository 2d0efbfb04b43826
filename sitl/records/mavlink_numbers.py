"""Numbers of MAVLink that more than one room speaks in."""

from collections.abc import Mapping
from enum import IntEnum

INT32_MAX = 2**31 - 1
NOT_GIVEN = INT32_MAX  # x or y that leaves the place to the vehicle, of an item or a COMMAND_INT


class MavResult(IntEnum):
    """MAV_RESULT: the answer to a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5


class MavState(IntEnum):
    """MAV_STATE, as HEARTBEAT shows it."""

    UNINIT = 0
    BOOT = 1
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5
    TERMINATED = 8


class MavFrame(IntEnum):
    """MAV_FRAME, as far as this vehicle understands it."""

    GLOBAL = 0
    LOCAL_NED = 1
    MISSION = 2
    GLOBAL_RELATIVE_ALT = 3
    GLOBAL_INT = 5
    GLOBAL_RELATIVE_ALT_INT = 6
    BODY_NED = 8
    GLOBAL_TERRAIN_ALT = 10
    GLOBAL_TERRAIN_ALT_INT = 11


INT_TWINS: Mapping[
    int, int
] = {  # of the frames of COMMAND_INT and the like: those of messages with floats
    MavFrame.GLOBAL_INT: MavFrame.GLOBAL,
    MavFrame.GLOBAL_RELATIVE_ALT_INT: MavFrame.GLOBAL_RELATIVE_ALT,
    MavFrame.GLOBAL_TERRAIN_ALT_INT: MavFrame.GLOBAL_TERRAIN_ALT,
}
GLOBAL_FRAMES = frozenset({*INT_TWINS, *INT_TWINS.values()})  # x and y are degrees * 1e7
