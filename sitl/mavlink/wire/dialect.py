"""The MAVLink dialect: pymavlink's message classes, which we pack and send ourselves.

`development` is `common` plus AVAILABLE_MODES and CURRENT_MODE, which PX4 1.15 and later speak.
"""

from typing import Any, TypeAlias

from pymavlink.dialects.v20 import development as mavlink

Message: TypeAlias = Any  # a mavlink.MAVLink_*_message; pymavlink ships no types

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1
REFEREE = 25  # MAV_COMP_ID_USER1
CAMERA = 100  # MAV_COMP_ID_CAMERA
OWN_COMPONENTS = frozenset({AUTOPILOT, REFEREE, CAMERA})

__all__ = ["AUTOPILOT", "CAMERA", "OWN_COMPONENTS", "REFEREE", "Message", "mavlink"]
