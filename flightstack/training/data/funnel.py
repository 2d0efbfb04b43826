"""The funnel expert: full knowledge of the gates, commands that a single image could justify.

The command depends on the pose alone, never on the velocity, because a policy that sees one
image cannot know it. In the frame of the gate that is due, the vehicle is drawn onto the gate's
axis while it advances along it; the closer the gate, the narrower the funnel in which it may
advance at speed, so from a bad state the expert slows, or backs off, until it is aligned. The
nose points at the gate, and over the last metres turns to the one after it.
"""

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from flightstack.arrays import PerVelocity
from flightstack.frames import body_from_ned, wrap_pi
from sitl import Gate, Vector3, VehicleState, yaw_of


@runtime_checkable
class Expert(Protocol):
    """A pilot that knows where the gates are."""

    def command(self, state: VehicleState, gate: Gate, following: Gate) -> PerVelocity:
        """Command for a state: vx, vy, vz (m/s, yaw-aligned body), yaw rate (rad/s)."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class ExpertConfig:
    """How briskly the expert flies."""

    speed_m_s: float = 2.0  # along the axis when aligned
    centring_speed_m_s: float = 1.6  # over `look_ahead` gives the gain onto the axis
    look_ahead_m: float = 1.8  # at least
    look_ahead_share: float = 0.7  # of the distance to the gate
    max_lateral_m_s: float = 1.6
    max_vertical_m_s: float = 1.2
    back_off_share: float = 0.25  # of the speed, backwards, when far outside the funnel
    turn_distance_m: float = 2.0  # from here on the nose turns to the following gate
    yaw_gain_1_s: float = 1.5
    max_yaw_rate_rad_s: float = 1.0


class FunnelExpert:
    """The expert of this file behind the interface that the data generation flies."""

    def __init__(self, config: ExpertConfig | None = None) -> None:
        self._config = config or ExpertConfig()

    def command(self, state: VehicleState, gate: Gate, following: Gate) -> PerVelocity:
        """Command for where the vehicle is."""
        yaw_rad = yaw_of(state.q_ned_frd)
        return expert_command(state.position_ned, yaw_rad, gate, following, self._config)


def expert_command(
    position_ned: Vector3, yaw_rad: float, gate: Gate, following: Gate, config: ExpertConfig
) -> PerVelocity:
    """Command for a pose: vx, vy, vz (m/s, yaw-aligned body frame), yaw rate (rad/s)."""
    axis_n, axis_e = math.cos(gate.yaw_rad), math.sin(gate.yaw_rad)
    north, east, down = (c - p for c, p in zip(gate.centre_ned, position_ned, strict=True))
    ahead = axis_n * north + axis_e * east  # m to go along the axis
    right = -axis_e * north + axis_n * east  # m by which the axis lies to the right
    reach = max(ahead, 0.0)

    gain = config.centring_speed_m_s / max(config.look_ahead_m, config.look_ahead_share * reach)
    lateral = _clamp(gain * right, config.max_lateral_m_s)
    vertical = _clamp(gain * down, config.max_vertical_m_s)
    funnel = 0.3 + 0.25 * reach + 0.12 * reach * reach
    aligned = 1.0 - (math.hypot(right, down) / funnel) ** 2
    along = config.speed_m_s * max(aligned, -config.back_off_share)

    velocity_ned = (
        along * axis_n - lateral * axis_e,
        along * axis_e + lateral * axis_n,
        vertical,
    )
    vx, vy, vz = body_from_ned(velocity_ned, yaw_rad)
    yaw_rate = _yaw_rate(position_ned, yaw_rad, gate, following, reach, config)
    return np.array([vx, vy, vz, yaw_rate])


def _yaw_rate(
    position_ned: Vector3,
    yaw_rad: float,
    gate: Gate,
    following: Gate,
    reach: float,
    config: ExpertConfig,
) -> float:
    share = max(0.0, 1.0 - reach / config.turn_distance_m)
    to_gate = _bearing(position_ned, gate)
    if reach < 0.5:  # the bearing of a gate that is almost passed spins; its axis does not
        to_gate = gate.yaw_rad
    turn = wrap_pi(_bearing(position_ned, following) - to_gate)
    error = wrap_pi(to_gate + share * turn - yaw_rad)
    return _clamp(config.yaw_gain_1_s * error, config.max_yaw_rate_rad_s)


def _bearing(position_ned: Vector3, gate: Gate) -> float:
    return math.atan2(gate.centre_ned[1] - position_ned[1], gate.centre_ned[0] - position_ned[0])


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
