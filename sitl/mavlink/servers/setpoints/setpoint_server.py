"""Take setpoints and sticks: SET_POSITION_TARGET_*, SET_ATTITUDE_TARGET, MANUAL_CONTROL.

Local NED: every axis may be ignored by itself. Body NED (turned by the heading alone, at
reception): position never counts, and one ignored velocity axis drops the whole velocity;
likewise acceleration. A setpoint that says nothing is refused with a text, like foreign frames.
Global positions become local ones here, by the vehicle's origin.
"""

import math

from sitl.frames import ned_from_geodetic
from sitl.mavlink.servers.setpoints.attitude_setpoint import interpret_attitude
from sitl.mavlink.servers.setpoints.manual_control import interpret_sticks
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import Message
from sitl.records.mavlink_numbers import MavFrame
from sitl.records.motion import Vector3
from sitl.records.texts import CRITICAL, StatusText
from sitl.records.vehicle import NAN_VECTOR, OffboardSetpoint

ABSURD = 1e6  # m, m/s, m/s2, rad: beyond it a number is taken as missing
VELOCITY_BIT, ACCELERATION_BIT = 3, 6  # where each triple begins in the type mask
YAW_IGNORED, YAW_RATE_IGNORED = 1 << 10, 1 << 11
FORCE = 1 << 9
LOCAL, GLOBAL = "SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT"
# Of global setpoints; those above the terrain, too: there is no data of it, and the ground is flat.
ABOVE_HOME_FRAMES = {MavFrame.GLOBAL_RELATIVE_ALT_INT, MavFrame.GLOBAL_TERRAIN_ALT_INT}


class SetpointServer:
    """Pass setpoints to the autopilot, and remember which camera image the last one answers."""

    def __init__(self, vehicle: SimulatedVehicle) -> None:
        self._vehicle = vehicle
        self._answered_us = -1

    def take_answer(self) -> int:
        """Give the time_boot_ms, in us, of the newest setpoint since the last call; -1 if none.

        A refused one counts too: its sender has seen the image.
        """
        answered_us, self._answered_us = self._answered_us, -1
        return answered_us

    def handle_global(self, message: Message) -> StatusText | None:
        """Take a SET_POSITION_TARGET_GLOBAL_INT addressed to us."""
        self._note_answer(message.time_boot_ms)
        autopilot = self._vehicle.autopilot
        status = autopilot.status
        setpoint = interpret_global(
            message, time_us=self._vehicle.time_us, origin=status.home, home_ned=status.home_ned
        )
        if isinstance(setpoint, StatusText):
            return setpoint
        autopilot.offboard_setpoint(setpoint)
        return None

    def handle_attitude(self, message: Message) -> StatusText | None:
        """Take a SET_ATTITUDE_TARGET addressed to us."""
        self._note_answer(message.time_boot_ms)
        target = interpret_attitude(message, time_us=self._vehicle.time_us)
        if isinstance(target, StatusText):
            return target
        self._vehicle.autopilot.attitude_setpoint(target)
        return None

    def handle_sticks(self, message: Message) -> None:
        """Take a MANUAL_CONTROL addressed to us; one that makes no sense counts as none."""
        sticks = interpret_sticks(message, time_us=self._vehicle.time_us)
        if sticks is not None:
            self._vehicle.autopilot.manual_control(sticks)

    def handle(self, message: Message) -> StatusText | None:
        """Take a SET_POSITION_TARGET_LOCAL_NED; the text says why it was refused."""
        self._note_answer(message.time_boot_ms)
        autopilot = self._vehicle.autopilot
        setpoint = interpret(message, time_us=self._vehicle.time_us, yaw_rad=autopilot.yaw_rad)
        if isinstance(setpoint, StatusText):
            return setpoint
        autopilot.offboard_setpoint(setpoint)
        return None

    def _note_answer(self, time_boot_ms: int) -> None:
        """Remember the image that is answered; nobody has seen one that is yet to come."""
        answered_us = time_boot_ms * 1000
        if answered_us <= self._vehicle.time_us:
            self._answered_us = max(self._answered_us, answered_us)


def interpret(message: Message, *, time_us: int, yaw_rad: float) -> OffboardSetpoint | StatusText:
    """Turn a message into a setpoint in local NED, or say why not."""
    mask = message.type_mask
    position = _triple((message.x, message.y, message.z), mask)
    velocity = _triple((message.vx, message.vy, message.vz), mask >> VELOCITY_BIT)
    acceleration = _triple((message.afx, message.afy, message.afz), mask >> ACCELERATION_BIT)
    if message.coordinate_frame == MavFrame.BODY_NED:
        position = NAN_VECTOR
        velocity = _from_body(velocity, mask >> VELOCITY_BIT, yaw_rad)
        acceleration = _from_body(acceleration, mask >> ACCELERATION_BIT, yaw_rad)
    elif message.coordinate_frame != MavFrame.LOCAL_NED:
        return _refused(LOCAL, f"coordinate frame {message.coordinate_frame} unsupported")
    return _complete(message, LOCAL, position, velocity, acceleration, time_us)


def interpret_global(
    message: Message, *, time_us: int, origin: Vector3, home_ned: Vector3
) -> OffboardSetpoint | StatusText:
    """Turn a message with a place on earth into a setpoint in local NED, or say why not."""
    mask, frame = message.type_mask, message.coordinate_frame
    if frame not in {MavFrame.GLOBAL_INT, *ABOVE_HOME_FRAMES}:
        return _refused(GLOBAL, f"coordinate frame {frame} unsupported")
    altitude_m = message.alt
    if frame in ABOVE_HOME_FRAMES:
        altitude_m += origin[2] - home_ned[2]
    place = (message.lat_int / 1e7, message.lon_int / 1e7, altitude_m)
    north, east, down = ned_from_geodetic(place, origin)
    velocity = _triple((message.vx, message.vy, message.vz), mask >> VELOCITY_BIT)
    acceleration = _triple((message.afx, message.afy, message.afz), mask >> ACCELERATION_BIT)
    position = _triple((north, east, down), mask)
    return _complete(message, GLOBAL, position, velocity, acceleration, time_us)


def _complete(
    message: Message,
    name: str,
    position: Vector3,
    velocity: Vector3,
    acceleration: Vector3,
    time_us: int,
) -> OffboardSetpoint | StatusText:
    mask = message.type_mask
    if mask & FORCE and not _is_missing(acceleration):
        return _refused(name, "force not supported")
    if all(_is_missing(triple) for triple in (position, velocity, acceleration)):
        return _refused(name, "invalid")
    return OffboardSetpoint(
        time_us=time_us,
        position_ned=position,
        velocity_ned=velocity,
        acceleration_ned=acceleration,
        yaw_rad=_number(message.yaw, ignored=bool(mask & YAW_IGNORED)),
        yaw_rate_rad_s=_number(message.yaw_rate, ignored=bool(mask & YAW_RATE_IGNORED)),
    )


def _refused(name: str, reason: str) -> StatusText:
    return StatusText(severity=CRITICAL, text=f"{name} {reason}")


def _number(value: float, *, ignored: bool) -> float:
    """Give the value, or NaN if it is ignored, not finite or absurd."""
    return value if not ignored and abs(value) <= ABSURD else math.nan


def _triple(values: Vector3, mask: int) -> Vector3:
    x, y, z = (_number(value, ignored=bool(mask >> axis & 1)) for axis, value in enumerate(values))
    return (x, y, z)


def _is_missing(triple: Vector3) -> bool:
    return all(math.isnan(value) for value in triple)


def _from_body(triple: Vector3, mask: int, yaw_rad: float) -> Vector3:
    """Turn a yaw-aligned body triple into NED; nothing of it if any axis is ignored."""
    if mask & 0b111:
        return NAN_VECTOR
    forward, right, down = triple
    cos_yaw, sin_yaw = math.cos(yaw_rad), math.sin(yaw_rad)
    return (cos_yaw * forward - sin_yaw * right, sin_yaw * forward + cos_yaw * right, down)
