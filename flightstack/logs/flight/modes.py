"""Name the flight modes of PX4 and ArduPilot as HEARTBEAT carries them."""

from pymavlink.dialects.v20 import all as mavlink

from flightstack.px4_modes import px4_name

PX4 = 12  # MAV_AUTOPILOT_PX4
ARDUPILOT = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
BASE_MODES = {4: "AUTO", 8: "GUIDED", 16: "STABILIZE", 64: "MANUAL"}  # flags of MAV_MODE_FLAG
NO_MODE = "not set"

ARDUPILOT_ENUMS = {  # MAV_TYPE: enumeration of its modes
    **dict.fromkeys((1, 19, 20, 21, 22, 23, 24, 25, 28), "PLANE_MODE"),
    **dict.fromkeys((2, 3, 4, 13, 14, 15, 29, 35, 43), "COPTER_MODE"),
    **dict.fromkeys((10, 11), "ROVER_MODE"),
    12: "SUB_MODE",
    5: "TRACKER_MODE",
}


def mode_name(autopilot: int, vehicle_type: int, base_mode: int, custom_mode: int) -> str:
    """Return a mode's name for people; one that is unknown by its number alone."""
    if autopilot == PX4 and custom_mode:
        return px4_name(custom_mode).removeprefix("mode ")
    enum = ARDUPILOT_ENUMS.get(vehicle_type)
    if autopilot == ARDUPILOT and enum and base_mode & CUSTOM_MODE_ENABLED:
        entry = mavlink.enums[enum].get(custom_mode)
        return str(entry.name).removeprefix(f"{enum}_") if entry else str(custom_mode)
    if custom_mode:
        return f"base {base_mode} custom {custom_mode}"
    return next((name for flag, name in BASE_MODES.items() if base_mode & flag), NO_MODE)
