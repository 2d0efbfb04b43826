"""Name PX4's flight modes as HEARTBEAT.custom_mode encodes them, and who is who on the link."""

from enum import IntEnum

AUTOPILOT_COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1
REFEREE_COMPONENT = 25  # MAV_COMP_ID_USER1: the simulator's judge of the course
CAMERA_COMPONENT = 100  # MAV_COMP_ID_CAMERA
COMPANION_COMPONENT = 191  # MAV_COMP_ID_ONBOARD_COMPUTER


class Px4Mode(IntEnum):
    """custom_mode = main << 16 | sub << 24, PX4 px4_custom_mode.h."""

    MANUAL = 0x00010000
    ALTITUDE = 0x00020000
    POSITION = 0x00030000
    ACRO = 0x00050000
    OFFBOARD = 0x00060000
    STABILIZED = 0x00070000
    TAKEOFF = 0x02040000
    LOITER = 0x03040000
    MISSION = 0x04040000
    RETURN = 0x05040000
    LAND = 0x06040000
    PRECISION_LAND = 0x09040000

    @property
    def main(self) -> int:
        """The main mode, as DO_SET_MODE's second parameter wants it."""
        return self >> 16 & 0xFF

    @property
    def sub(self) -> int:
        """The sub mode, as DO_SET_MODE's third parameter wants it."""
        return self >> 24


def mode_name(custom_mode: int) -> str:
    """Name a mode for people; one that is unknown by its number."""
    try:
        return Px4Mode(custom_mode).name.capitalize().replace("_", " ")
    except ValueError:
        return f"mode 0x{custom_mode:08x}"
