"""Read SET_ATTITUDE_TARGET: an attitude or body rates, and a thrust, by PX4's rules."""

import math

from sitl.mavlink.wire.dialect import Message
from sitl.records.motion import Quaternion, Vector3
from sitl.records.texts import CRITICAL, StatusText
from sitl.records.vehicle import AttitudeTarget

RATES_IGNORED = (1, 2, 4)  # ATTITUDE_TARGET_TYPEMASK: roll, pitch, yaw rate
THRUST_IGNORED, ATTITUDE_IGNORED = 64, 128
RATE_MAX_RAD_S = 100.0  # beyond it a rate is taken as missing
UNIT_TOLERANCE = 0.1  # how far from 1 the norm of an attitude may be
REFUSED = StatusText(severity=CRITICAL, text="SET_ATTITUDE_TARGET invalid")


def interpret_attitude(message: Message, *, time_us: int) -> AttitudeTarget | StatusText:
    """Turn a message into a target, or say why not.

    Where an attitude is given it leads, and of the rates only yaw counts; otherwise all three do.
    """
    mask, thrust = message.type_mask, message.thrust
    if mask & THRUST_IGNORED or not 0.0 <= thrust <= 1.0:
        return REFUSED
    rates = _rates(message)
    if not mask & ATTITUDE_IGNORED:
        q = _normalised(message.q)
        if q is None:
            return REFUSED
        yaw_rate = 0.0 if math.isnan(rates[2]) else rates[2]
        return AttitudeTarget(
            time_us=time_us, q_ned_frd=q, rates_frd=(0.0, 0.0, yaw_rate), thrust=thrust
        )
    if any(math.isnan(rate) for rate in rates):
        return REFUSED
    return AttitudeTarget(time_us=time_us, q_ned_frd=None, rates_frd=rates, thrust=thrust)


def _rates(message: Message) -> Vector3:
    """Give the rates, NaN where ignored or absurd."""
    given = (message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate)
    x, y, z = (
        rate if not message.type_mask & bit and abs(rate) <= RATE_MAX_RAD_S else math.nan
        for rate, bit in zip(given, RATES_IGNORED, strict=True)
    )
    return (x, y, z)


def _normalised(q: Quaternion) -> Quaternion | None:
    w, x, y, z = q
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    if not abs(norm - 1.0) <= UNIT_TOLERANCE:  # NaN, too
        return None
    return (w / norm, x / norm, y / norm, z / norm)
