"""PX4's flight modes and how HEARTBEAT encodes them."""

from enum import Enum
from typing import NamedTuple

BASE_CUSTOM = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
BASE_ATTITUDE = 16  # MAV_MODE_FLAG_STABILIZE_ENABLED: attitude is controlled
BASE_MANUAL = 64  # MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
BASE_ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
BASE_AUTO = 4 + 8 + BASE_ATTITUDE  # auto, guided, attitude

MAIN_AUTO = 4
MAIN_OFFBOARD = 6


class Encoding(NamedTuple):
    """How one mode stands in HEARTBEAT: PX4's main and sub mode, and base_mode when disarmed."""

    main: int
    sub: int
    base: int


class Mode(Enum):
    """A navigation state. The values are what HEARTBEAT shows (seen from a running PX4 1.17)."""

    def __init__(self, main: int, sub: int, base: int) -> None:
        self.base_mode = base
        self.custom_mode = main << 16 | sub << 24  # HEARTBEAT.custom_mode, as PX4 packs it

    __hash__ = object.__hash__  # modes are looked up at every tick: that of enumerations is slow

    MANUAL = Encoding(1, 0, BASE_CUSTOM | BASE_MANUAL | BASE_ATTITUDE)
    ALTCTL = Encoding(2, 0, BASE_CUSTOM | BASE_MANUAL | BASE_ATTITUDE)
    POSCTL = Encoding(3, 0, BASE_CUSTOM | BASE_MANUAL | BASE_ATTITUDE)
    TAKEOFF = Encoding(MAIN_AUTO, 2, BASE_CUSTOM | BASE_AUTO)
    HOLD = Encoding(MAIN_AUTO, 3, BASE_CUSTOM | BASE_AUTO)  # AUTO.LOITER
    MISSION = Encoding(MAIN_AUTO, 4, BASE_CUSTOM | BASE_AUTO)
    RTL = Encoding(MAIN_AUTO, 5, BASE_CUSTOM | BASE_AUTO)
    LAND = Encoding(MAIN_AUTO, 6, BASE_CUSTOM | BASE_AUTO)
    FOLLOW = Encoding(MAIN_AUTO, 8, BASE_CUSTOM | BASE_ATTITUDE)
    PRECLAND = Encoding(MAIN_AUTO, 9, BASE_CUSTOM | BASE_AUTO)
    ACRO = Encoding(5, 0, BASE_CUSTOM | BASE_MANUAL)
    OFFBOARD = Encoding(MAIN_OFFBOARD, 0, BASE_CUSTOM)  # + attitude while setpoints arrive
    STABILIZED = Encoding(7, 0, BASE_CUSTOM | BASE_MANUAL | BASE_ATTITUDE)
    TERMINATION = Encoding(10, 0, BASE_CUSTOM)


def mode_of(main: int, sub: int) -> Mode | None:
    """Find the mode that PX4's main and sub mode name; None if there is none."""
    if main == MAIN_AUTO:
        return _BY_NUMBERS.get((main, sub))
    return _BY_NUMBERS.get((main, 0))


_BY_NUMBERS = {(mode.value.main, mode.value.sub): mode for mode in Mode}
