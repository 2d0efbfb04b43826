"""PX4's flight modes; they stand in `sitl.modes`, shared with MAVLink."""

from sitl.modes import (
    BASE_ARMED,
    BASE_ATTITUDE,
    BASE_AUTO,
    BASE_CUSTOM,
    BASE_MANUAL,
    MAIN_AUTO,
    MAIN_OFFBOARD,
    Encoding,
    Mode,
    mode_of,
)

__all__ = [
    "BASE_ARMED",
    "BASE_ATTITUDE",
    "BASE_AUTO",
    "BASE_CUSTOM",
    "BASE_MANUAL",
    "MAIN_AUTO",
    "MAIN_OFFBOARD",
    "Encoding",
    "Mode",
    "mode_of",
]
