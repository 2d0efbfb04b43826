"""The mixer: normalised torques and a collective thrust become four rotor thrusts.

Without airmode: a rotor that would leave 0..1 costs yaw first, then collective thrust (downwards
only), then roll and pitch. Thrust is taken as linear in the command.
"""

import math
from collections.abc import Sequence

import numpy as np

from sitl.records.motion import MotorThrusts, Vector3

# Rotor thrusts, and on each axis the sign of the torque that had to be cut (0: none).
# A plain tuple: a named one would cost each tick 0.2 us of its 24.
Mixed = tuple[MotorThrusts, Vector3]

UNCUT: Vector3 = (0.0, 0.0, 0.0)
YAW_MARGIN = 0.15  # thrust that may be given up, so that some yaw control stays (as PX4 keeps)


class Mixer:
    """Maps (roll, pitch, yaw, thrust) to rotors laid out as the airframe has them.

    Scaled as PX4's control allocation is: unit thrust is every rotor at 1, unit yaw moves the
    rotors by 1, unit roll and pitch by 1 / sqrt(2) on a symmetric quadrotor.
    """

    def __init__(
        self,
        positions_frd_m: Sequence[tuple[float, float]],
        yaw_moments_m: Sequence[float],
    ) -> None:
        effectiveness = np.array(
            [
                [-y for _, y in positions_frd_m],
                [x for x, _ in positions_frd_m],
                yaw_moments_m,
                [1.0] * len(positions_frd_m),
            ]
        )
        mix = np.linalg.inv(effectiveness)  # (rotor, axis)
        tilt_scale = max(math.sqrt(float((mix[:, axis] ** 2).sum()) / 2.0) for axis in (0, 1))
        mix[:, :2] /= tilt_scale
        mix[:, 2] /= np.abs(mix[:, 2]).max()
        mix[:, 3] /= mix[:, 3].mean()
        self._rows = tuple(tuple(float(value) for value in row) for row in mix)

    def mix(self, torque: Vector3, thrust: float) -> Mixed:
        """Give rotor thrusts in 0..1, and what had to be cut."""
        roll, pitch, yaw = torque
        (r0, p0, y0, t0), (r1, p1, y1, t1), (r2, p2, y2, t2), (r3, p3, y3, t3) = self._rows
        tilt = (
            r0 * roll + p0 * pitch,
            r1 * roll + p1 * pitch,
            r2 * roll + p2 * pitch,
            r3 * roll + p3 * pitch,
        )
        lift = (t0 * thrust, t1 * thrust, t2 * thrust, t3 * thrust)
        turn = (y0 * yaw, y1 * yaw, y2 * yaw, y3 * yaw)
        full = (
            lift[0] + tilt[0] + turn[0],
            lift[1] + tilt[1] + turn[1],
            lift[2] + tilt[2] + turn[2],
            lift[3] + tilt[3] + turn[3],
        )
        if min(full) >= 0.0 and max(full) <= 1.0:
            return full, UNCUT
        return _desaturate(lift, tilt, turn, torque)


def _desaturate(
    lift: MotorThrusts, tilt: MotorThrusts, turn: MotorThrusts, torque: Vector3
) -> Mixed:
    spread = max(tilt) - min(tilt)
    tilt_scale = 1.0 if spread <= 1.0 else 1.0 / spread
    # Lower the thrust until the highest rotor fits, as far as the lowest allows.
    high = max(f + tilt_scale * g for f, g in zip(lift, tilt, strict=True)) - 1.0
    low = min(f + tilt_scale * g for f, g in zip(lift, tilt, strict=True))
    drop = min(max(high, 0.0), max(low, 0.0))
    base = [f - drop for f in lift]
    # Without airmode the thrust is never raised: roll and pitch shrink to what is left.
    for f, g in zip(base, tilt, strict=True):
        room = max(0.0, 1.0 - f if g > 0.0 else f)
        if tilt_scale * abs(g) > room:
            tilt_scale = room / abs(g)
    level = [f + tilt_scale * g for f, g in zip(base, tilt, strict=True)]
    # Yaw last; a little thrust may be given up for it.
    drop = min(YAW_MARGIN, max(0.0, min(level)), _overflow(level, turn))
    level = [value - drop for value in level]
    yaw_scale = 1.0
    for value, g in zip(level, turn, strict=True):
        room = max(0.0, 1.0 - value if g > 0.0 else value)
        if yaw_scale * abs(g) > room:
            yaw_scale = room / abs(g)
    a, b, c, d = (
        min(max(value + yaw_scale * g, 0.0), 1.0) for value, g in zip(level, turn, strict=True)
    )
    tilt_cut, yaw_cut = tilt_scale < 1.0, yaw_scale < 1.0
    saturated = (
        math.copysign(tilt_cut, torque[0]),
        math.copysign(tilt_cut, torque[1]),
        math.copysign(yaw_cut, torque[2]),
    )
    return (a, b, c, d), saturated


def _overflow(level: Sequence[float], turn: MotorThrusts) -> float:
    """How far the highest rotor would leave 1 with all of the yaw."""
    return max(0.0, *(value + g - 1.0 for value, g in zip(level, turn, strict=True)))
