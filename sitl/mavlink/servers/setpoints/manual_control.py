"""Read MANUAL_CONTROL: the sticks of a ground station's joystick."""

from sitl.mavlink.wire.dialect import Message
from sitl.records.vehicle import Sticks

FULL = 1000  # of every axis; the throttle's centre is half of it


def interpret_sticks(message: Message, *, time_us: int) -> Sticks | None:
    """Turn a message into stick positions; None if an axis is missing or out of range."""
    x, y, z, r = message.x, message.y, message.z, message.r
    if any(abs(axis) > FULL for axis in (x, y, z, r)):
        return None
    return Sticks(
        time_us=time_us,
        forward=x / FULL,
        right=y / FULL,
        up=max(2.0 * z / FULL - 1.0, -1.0),
        turn=r / FULL,
    )
