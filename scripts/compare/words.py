"""What scripts say to a vehicle: commands, parameters, places, plans."""

import math
import struct
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import development as mavlink

NAN = math.nan
HOME_DEG, HOME_AMSL_M = (47.397742, 8.545594), 489.4  # the default home
METRES_A_DEGREE = 111_195.0
MISSION, FENCE, RALLY = 0, 1, 2  # MAV_MISSION_TYPE
ABOVE_HOME = 6  # MAV_FRAME_GLOBAL_RELATIVE_ALT_INT


def packed(message: Any, codec: Any) -> bytes:
    """Pack a message, and count it."""
    packet = bytes(message.pack(codec))
    codec.seq = (codec.seq + 1) % 256
    return packet


def command(number: int, *params: float, component: int = 1) -> Any:
    """Make a COMMAND_LONG; what is not given is 0."""
    values = [*params, *[0.0] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(1, component, number, 0, *values)


def change_mode(main: int, sub: int = 0) -> Any:
    """Ask for a flight mode by PX4's numbers."""
    return command(176, 1.0, float(main), float(sub))


def parameter(name: str, value: float) -> Any:
    """Set a parameter, an integer bytewise."""
    is_integer = isinstance(value, int)
    number = struct.unpack("<f", struct.pack("<i", value))[0] if is_integer else value
    kind = mavlink.MAV_PARAM_TYPE_INT32 if is_integer else mavlink.MAV_PARAM_TYPE_REAL32
    return mavlink.MAVLink_param_set_message(1, 1, name.encode(), number, kind)


def place(north_m: float, east_m: float) -> tuple[float, float]:
    """Latitude and longitude, degrees."""
    latitude, longitude = HOME_DEG
    across = METRES_A_DEGREE * math.cos(math.radians(latitude))
    return latitude + north_m / METRES_A_DEGREE, longitude + east_m / across


def reposition(north_m: float, east_m: float, height_m: float, yaw_rad: float = NAN) -> Any:
    """Go there, in hold."""
    return command(192, -1.0, 1.0, 0.0, yaw_rad, *place(north_m, east_m), HOME_AMSL_M + height_m)


class Item(NamedTuple):
    """An item of a plan, its place in metres from home."""

    command: int
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, NAN)
    north_m: float = 0.0
    east_m: float = 0.0
    height_m: float = 0.0
    frame: int = ABOVE_HOME

    def message(self, sequence: int, kind: int) -> Any:
        """Make a MISSION_ITEM_INT."""
        latitude, longitude = place(self.north_m, self.east_m)
        degrees = (round(latitude * 1e7), round(longitude * 1e7))
        return mavlink.MAVLink_mission_item_int_message(
            *(1, 1, sequence, self.frame, self.command, int(sequence == 0), 1, *self.params),
            *(*degrees, self.height_m, kind),
        )
