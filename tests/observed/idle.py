"""What a real PX4 was seen to show on the ground: fields of its messages, NaN included."""

import math
from typing import Any

NAN = math.nan
LOAD_PERMILLE = (100, 160)  # SYS_STATUS.load
IDLE: dict[str, dict[str, Any]] = {
    "SYS_STATUS": {
        "onboard_control_sensors_present": 0x0300402F,
        "onboard_control_sensors_enabled": 0x0301402F,
        "onboard_control_sensors_health": 0x1320C83F,
        "voltage_battery": 16200,
        "current_battery": -100,
        "battery_remaining": 100,
    },
    "EXTENDED_SYS_STATE": {"vtol_state": 0, "landed_state": 1},
    "MISSION_CURRENT": {"seq": 0, "total": 65535, "mission_state": 1, "mission_mode": 2},
    "GPS_RAW_INT": {"fix_type": 3, "satellites_visible": 10, "eph": 70, "epv": 110},
    "ESTIMATOR_STATUS": {"flags": 1023},
    "BATTERY_STATUS": {"voltages": [16200, *[65535] * 9], "charge_state": 1},
    "SERVO_OUTPUT_RAW": {f"servo{n}_raw": 900 for n in range(1, 17)},
    "HOME_POSITION": {},
    "POSITION_TARGET_LOCAL_NED": {
        "coordinate_frame": 1,
        "type_mask": 63,
        **dict.fromkeys(("x", "y", "z", "vx", "vy", "vz"), NAN),
        "afx": 0.0,
        "afy": 0.0,
        "afz": 100.0,
    },
    "ATTITUDE_TARGET": {"type_mask": 0},
    "VFR_HUD": {"airspeed": NAN},
}
