"""Number and name PX4's flight modes, as HEARTBEAT.custom_mode and DO_SET_MODE carry them."""

from enum import IntEnum

# PX4 px4_custom_mode.h: custom_mode = main << 16 | sub << 24.


class MainMode(IntEnum):
    """PX4_CUSTOM_MAIN_MODE."""

    MANUAL = 1
    ALTCTL = 2
    POSCTL = 3
    AUTO = 4
    ACRO = 5
    OFFBOARD = 6
    STABILIZED = 7
    RATTITUDE = 8
    TERMINATION = 10
    ALTITUDE_CRUISE = 11


class AutoMode(IntEnum):
    """PX4_CUSTOM_SUB_MODE_AUTO."""

    READY = 1
    TAKEOFF = 2
    LOITER = 3
    MISSION = 4
    RTL = 5
    LAND = 6
    FOLLOW = 8
    PRECLAND = 9
    VTOL_TAKEOFF = 10


class PositionMode(IntEnum):
    """PX4_CUSTOM_SUB_MODE_POSCTL."""

    ORBIT = 1
    SLOW = 2


SUB_MODES: dict[MainMode, type[IntEnum]] = {
    MainMode.AUTO: AutoMode,
    MainMode.POSCTL: PositionMode,
}


class Px4Mode(IntEnum):
    """The modes of a multicopter that flies, under the names that people give them."""

    MANUAL = MainMode.MANUAL << 16
    ALTITUDE = MainMode.ALTCTL << 16
    POSITION = MainMode.POSCTL << 16
    ACRO = MainMode.ACRO << 16
    OFFBOARD = MainMode.OFFBOARD << 16
    STABILIZED = MainMode.STABILIZED << 16
    TAKEOFF = MainMode.AUTO << 16 | AutoMode.TAKEOFF << 24
    LOITER = MainMode.AUTO << 16 | AutoMode.LOITER << 24
    MISSION = MainMode.AUTO << 16 | AutoMode.MISSION << 24
    RETURN = MainMode.AUTO << 16 | AutoMode.RTL << 24
    LAND = MainMode.AUTO << 16 | AutoMode.LAND << 24
    PRECISION_LAND = MainMode.AUTO << 16 | AutoMode.PRECLAND << 24

    @property
    def main(self) -> int:
        """The main mode, as DO_SET_MODE's second parameter wants it."""
        return self >> 16 & 0xFF

    @property
    def sub(self) -> int:
        """The sub mode, as DO_SET_MODE's third parameter wants it."""
        return self >> 24


def spoken_name(custom_mode: int) -> str:
    """Name a mode as people do; one that is unknown by its number."""
    try:
        return Px4Mode(custom_mode).name.capitalize().replace("_", " ")
    except ValueError:
        return _number(custom_mode)


def px4_name(custom_mode: int) -> str:
    """Name a mode as PX4 does, AUTO.LOITER; one that is unknown by its number."""
    main, sub = custom_mode >> 16 & 0xFF, custom_mode >> 24 & 0xFF
    try:
        mode = MainMode(main)
    except ValueError:
        return _number(custom_mode)
    if mode not in SUB_MODES or (mode is MainMode.POSCTL and not sub):
        return mode.name
    known = {each.value: each.name for each in SUB_MODES[mode]}
    return f"{mode.name}.{known.get(sub, sub)}"


def _number(custom_mode: int) -> str:
    return f"mode 0x{custom_mode:08x}"
