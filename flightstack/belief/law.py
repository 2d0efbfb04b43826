"""The law of the expert that trains policies, on M samples of a believed gate at once.

In the frame of the gate the vehicle is drawn onto its axis while it advances along it; the closer
the gate, the narrower the funnel in which it may advance at speed. The nose points at the gate, and
over the last metres turns to the one after it. `flightstack.training.data.funnel` explains it.
"""

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.belief.settings import LawSettings

Points = Float64[NDArray[np.float64], "M 3"]
Angles = Float64[NDArray[np.float64], " M"]
AXIS_M = 0.5  # nearer, the bearing of a gate spins; its axis does not


def velocities(
    gate: Points,
    axis_rad: Angles,
    following: Points,
    position: Points,
    yaw_rad: float,
    law: LawSettings,
) -> tuple[Points, Angles]:
    """Return the wanted velocity NED (m/s) and the yaw rate (rad/s) for each sample."""
    axis = np.stack([np.cos(axis_rad), np.sin(axis_rad)], axis=1)
    offset = gate - position
    ahead = (offset[:, :2] * axis).sum(axis=1)
    right = offset[:, 1] * axis[:, 0] - offset[:, 0] * axis[:, 1]
    down = offset[:, 2]
    reach = np.maximum(ahead, 0.0)
    gain = law.centring_speed_m_s / np.maximum(law.look_ahead_m, law.look_ahead_share * reach)
    lateral = np.clip(gain * right, -law.max_lateral_m_s, law.max_lateral_m_s)
    vertical = np.clip(gain * down, -law.max_vertical_m_s, law.max_vertical_m_s)
    funnel = 0.3 + 0.25 * reach + 0.12 * reach * reach
    aligned = 1.0 - (right * right + down * down) / (funnel * funnel)
    along = law.speed_m_s * np.maximum(aligned, -law.back_off_share)
    north = along * axis[:, 0] - lateral * axis[:, 1]
    east = along * axis[:, 1] + lateral * axis[:, 0]
    to_gate = np.where(reach < AXIS_M, axis_rad, np.arctan2(offset[:, 1], offset[:, 0]))
    after = following - position
    share = np.maximum(0.0, 1.0 - reach / law.turn_distance_m)
    turn = _wrapped(np.arctan2(after[:, 1], after[:, 0]) - to_gate)
    error = _wrapped(to_gate + share * turn - yaw_rad)
    limit = law.max_yaw_rate_rad_s
    return np.stack([north, east, vertical], axis=1), np.clip(
        law.yaw_gain_1_s * error, -limit, limit
    )


def _wrapped(angle: Angles) -> Angles:
    return np.asarray(np.mod(angle + np.pi, 2.0 * np.pi) - np.pi)
