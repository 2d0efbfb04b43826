"""Attitude control: a quaternion P controller that corrects tilt before heading.

After Brescianini, Hehn, D'Andrea, "Nonlinear Quadrocopter Attitude Control" (2013), with the weight
on yaw that PX4 gives it (MC_YAW_WEIGHT).
"""

from math import atan2, cos, radians, sin, sqrt
from typing import NamedTuple, Self

from sitl.autopilot.control.arithmetic import clamp
from sitl.autopilot.parameters import ParameterValues
from sitl.records.motion import Quaternion, Vector3


class AttitudeParameters(NamedTuple):
    """How hard an attitude error is met."""

    yaw_weight: float  # MC_YAW_WEIGHT
    gains: Vector3  # 1/s, MC_ROLL_P, MC_PITCH_P, MC_YAW_P
    rate_max_frd: Vector3  # rad/s, MC_ROLLRATE_MAX, MC_PITCHRATE_MAX, MC_YAWRATE_MAX

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        weight = values["MC_YAW_WEIGHT"]
        yaw_p = values["MC_YAW_P"]  # undo the weight, so that pure yaw errors see the full gain
        return cls(
            yaw_weight=weight,
            gains=(
                values["MC_ROLL_P"],
                values["MC_PITCH_P"],
                yaw_p / weight if weight > 1e-4 else yaw_p,
            ),
            rate_max_frd=(
                radians(values["MC_ROLLRATE_MAX"]),
                radians(values["MC_PITCHRATE_MAX"]),
                radians(values["MC_YAWRATE_MAX"]),
            ),
        )


def turning_rates(
    q: Quaternion, target: Quaternion, yaw_rate_rad_s: float, parameters: AttitudeParameters
) -> Vector3:
    """Give body rates (rad/s, FRD) that turn `q` into the target; the yaw rate feeds forward."""
    yaw_weight, gains, limit = parameters
    w, x, y, z = q
    tw, tx, ty, tz = target
    # The error: the conjugate of q, times the target.
    ew = w * tw + x * tx + y * ty + z * tz
    ex = w * tx - x * tw - y * tz + z * ty
    ey = w * ty + x * tz - y * tw - z * tx
    ez = w * tz - x * ty + y * tx - z * tw
    # The target's z axis seen from the body, and the smallest turn that brings it there.
    bx, by, bz = (
        2.0 * (ex * ez + ew * ey),
        2.0 * (ey * ez - ew * ex),
        1.0 - 2.0 * (ex * ex + ey * ey),
    )
    norm = sqrt((1.0 + bz) ** 2 + bx * bx + by * by)
    if norm > 1e-5:
        rw, rx, ry = (1.0 + bz) / norm, -by / norm, bx / norm
        mw, mz = rw * ew + rx * ex + ry * ey, rw * ez - rx * ey + ry * ex  # what is left: yaw
        half = yaw_weight * atan2(mz, mw) if mw >= 0.0 else yaw_weight * atan2(-mz, -mw)
        c, s = cos(half), sin(half)
        ew, ex, ey, ez = rw * c, rx * c + ry * s, ry * c - rx * s, rw * s
    sign = 2.0 if ew >= 0.0 else -2.0
    # NED down in the body frame carries the yaw rate.
    roll = sign * ex * gains[0] + yaw_rate_rad_s * 2.0 * (x * z - w * y)
    pitch = sign * ey * gains[1] + yaw_rate_rad_s * 2.0 * (y * z + w * x)
    yaw = sign * ez * gains[2] + yaw_rate_rad_s * (1.0 - 2.0 * (x * x + y * y))
    return (
        clamp(roll, limit[0]),
        clamp(pitch, limit[1]),
        clamp(yaw, limit[2]),
    )
