"""Name the flight modes of PX4 and ArduPilot as HEARTBEAT carries them."""

from pymavlink.dialects.v20 import all as mavlink

PX4 = 12  # MAV_AUTOPILOT_PX4
ARDUPILOT = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED

PX4_MAIN = {
    1: "MANUAL",
    2: "ALTCTL",
    3: "POSCTL",
    4: "AUTO",
    5: "ACRO",
    6: "OFFBOARD",
    7: "STABILIZED",
    8: "RATTITUDE",
    10: "TERMINATION",
    11: "ALTITUDE_CRUISE",
}
PX4_AUTO_SUB = {
    1: "READY",
    2: "TAKEOFF",
    3: "LOITER",
    4: "MISSION",
    5: "RTL",
    6: "LAND",
    8: "FOLLOW",
    9: "PRECLAND",
    10: "VTOL_TAKEOFF",
}
PX4_POSITION_SUB = {1: "ORBIT", 2: "SLOW"}

ARDUPILOT_ENUMS = {  # MAV_TYPE: enumeration of its modes
    **dict.fromkeys((1, 19, 20, 21, 22, 23, 24, 25, 28), "PLANE_MODE"),
    **dict.fromkeys((2, 3, 4, 13, 14, 15, 29, 35, 43), "COPTER_MODE"),
    **dict.fromkeys((10, 11), "ROVER_MODE"),
    12: "SUB_MODE",
    5: "TRACKER_MODE",
}


def px4_mode(custom_mode: int) -> str:
    """Return PX4's name of a custom mode, main << 16 | sub << 24."""
    main, sub = custom_mode >> 16 & 0xFF, custom_mode >> 24 & 0xFF
    name = PX4_MAIN.get(main)
    if name == "AUTO":
        return f"AUTO.{PX4_AUTO_SUB.get(sub, sub)}"
    if name == "POSCTL" and sub:
        return f"POSCTL.{PX4_POSITION_SUB.get(sub, sub)}"
    return name or f"mode 0x{custom_mode:08x}"


def mode_name(autopilot: int, vehicle_type: int, base_mode: int, custom_mode: int) -> str:
    """Return a mode's name for people; one that is unknown by its number."""
    if autopilot == PX4:
        return px4_mode(custom_mode)
    enum = ARDUPILOT_ENUMS.get(vehicle_type)
    if autopilot == ARDUPILOT and enum and base_mode & CUSTOM_MODE_ENABLED:
        entry = mavlink.enums[enum].get(custom_mode)
        return str(entry.name).removeprefix(f"{enum}_") if entry else f"mode {custom_mode}"
    return f"base {base_mode} custom {custom_mode}"
