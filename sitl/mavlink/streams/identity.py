"""Encode who the vehicle is: version, capabilities, modes, home."""

import math
import struct

from sitl.frames import geodetic_from_ned, quaternion_from_euler
from sitl.mavlink.streams.health import STANDARD_MODES
from sitl.mavlink.streams.view import View, degrees_e7, int32
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.packets import Packed
from sitl.records.modes import Mode

VERSION = 0x011100FF  # the PX4 whose behaviour we show: 1.17.0, official release
CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FTP
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)
HARDWARE_UID = 0x53494D00  # "SIM", plus the system id
PROTOCOL_VERSION_ID = 300
PROTOCOL_VERSION_CRC_EXTRA = 217  # of MAVLink's PROTOCOL_VERSION, which pymavlink leaves out
PROTOCOL_VERSION_PAYLOAD = struct.Struct("<3H8s8s")
PROTOCOL_MINIMUM, PROTOCOL_MAXIMUM = 100, 200  # MAVLink 1.0, 2.0
MODE_NAMES = {Mode.HOLD: "Hold", Mode.PRECLAND: "Precision Land", Mode.FOLLOW: "Follow Target"}
MODES = tuple(Mode)


def autopilot_version(system: int) -> Message:
    """AUTOPILOT_VERSION."""
    uid = HARDWARE_UID + system
    return mavlink.MAVLink_autopilot_version_message(
        CAPABILITIES,
        VERSION,
        VERSION,
        0,
        0,
        (0,) * 8,
        (0,) * 8,
        (0,) * 8,
        0,
        0,
        uid,
        tuple(uid.to_bytes(18, "big")),
    )


def protocol_version() -> Packed:
    """PROTOCOL_VERSION: MAVLink 2."""
    payload = PROTOCOL_VERSION_PAYLOAD.pack(
        PROTOCOL_MAXIMUM, PROTOCOL_MINIMUM, PROTOCOL_MAXIMUM, b"", b""
    )
    return Packed(PROTOCOL_VERSION_ID, payload.rstrip(b"\0"), PROTOCOL_VERSION_CRC_EXTRA)


def available_modes(index: int) -> list[Message]:
    """AVAILABLE_MODES number `index` from 1, all for 0, none for a number that is not there."""
    wanted = range(1, len(MODES) + 1) if index == 0 else [index]
    return [_available_mode(number) for number in wanted if 1 <= number <= len(MODES)]


def _available_mode(number: int) -> Message:
    mode = MODES[number - 1]
    standard = STANDARD_MODES.get(mode.name, 0)
    name = "" if standard else MODE_NAMES.get(mode, mode.name.capitalize())
    return mavlink.MAVLink_available_modes_message(
        len(MODES), number, standard, mode.custom_mode, 0, name.encode()
    )


def home_position(view: View) -> Message | None:
    """HOME_POSITION, once there is one."""
    status = view.status
    if not status.home_valid:
        return None
    latitude, longitude, altitude_m = geodetic_from_ned(status.home_ned, status.home)
    return mavlink.MAVLink_home_position_message(
        degrees_e7(latitude),
        degrees_e7(longitude),
        int32(altitude_m * 1e3),
        *status.home_ned,
        quaternion_from_euler(0.0, 0.0, 0.0),
        math.nan,
        math.nan,
        math.nan,
        view.time_us,
    )
