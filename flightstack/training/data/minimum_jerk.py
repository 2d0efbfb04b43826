"""The lineage's expert: minimum-jerk segments from gate to gate, planned anew near each gate.

Within half a metre of a gate's centre the next segment begins, to the following gate's centre: a
quintic in each axis that starts at the vehicle's position and velocity, and arrives along the
gate's axis. Its duration is the shortest that keeps speed and acceleration below their limits and
the mean speed at the lineage's.

References:
    Bonatti et al. 2020, Learning visuomotor policies for aerial navigation using cross-modal
    representations: segments, limits and the replanning distance.
    Mellinger and Kumar 2011; a minimum-jerk curve between two full states is a quintic.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.arrays import PerVelocity
from flightstack.frames import body_from_ned, wrap_pi
from sitl import Gate, VehicleState, yaw_of

REPLAN_DISTANCE_M = 0.5  # Bonatti et al. 2020
MAX_SPEED_M_S = 5.0  # Bonatti et al. 2020
MAX_ACCELERATION_M_S2 = 3.0  # Bonatti et al. 2020
MEAN_SPEED_M_S = 1.5  # of the lineage's commands
ARRIVAL_SPEED_M_S = MEAN_SPEED_M_S
TRACKING_GAIN_1_S = 1.0  # of the position error, onto the planned velocity
LEAD_S = 0.25  # the vehicle's velocity follows its command this much later
YAW_GAIN_1_S = 1.5
MAX_YAW_RATE_RAD_S = 1.0  # the lineage's command range
MIN_DURATION_S, MAX_DURATION_S, DURATION_STEP_S = 0.4, 60.0, 0.1
CHECKED_POINTS = np.linspace(0.0, 1.0, 41)


@dataclass(frozen=True, slots=True, kw_only=True)
class Segment:
    """A quintic from `start_us` on; coefficients of t^0 .. t^5, metres NED."""

    start_us: int
    duration_s: float
    coefficients: Float64[NDArray[np.float64], "6 3"]

    def at(self, time_s: float, derivative: int = 0) -> Float64[NDArray[np.float64], "3"]:
        """Position, or one of its derivatives, at a time since the start, ends held."""
        t = min(max(time_s, 0.0), self.duration_s)
        coefficients = self.coefficients
        for _ in range(derivative):
            coefficients = coefficients[1:] * np.arange(1, len(coefficients))[:, None]
        return np.asarray((t ** np.arange(len(coefficients))) @ coefficients)


class MinimumJerkExpert:
    """Follow one segment after another; the nose points at the gate that is flown to."""

    def __init__(self) -> None:
        self._segment: Segment | None = None
        self._target: Gate | None = None

    def command(self, state: VehicleState, gate: Gate, following: Gate) -> PerVelocity:
        """Command that keeps the vehicle on its segment."""
        near = math.dist(state.position_ned, gate.centre_ned) < REPLAN_DISTANCE_M
        target = following if near else gate
        if self._segment is None or (self._target is not target and self._target is not following):
            self._segment, self._target = plan(state, target), target
        target = self._target or target
        elapsed_s = (state.time_us - self._segment.start_us) / 1e6
        position = self._segment.at(elapsed_s)
        velocity = self._segment.at(elapsed_s + LEAD_S, derivative=1)
        wanted = velocity + TRACKING_GAIN_1_S * (position - np.array(state.position_ned))
        yaw_rad = yaw_of(state.q_ned_frd)
        vx, vy, vz = body_from_ned((float(wanted[0]), float(wanted[1]), float(wanted[2])), yaw_rad)
        return np.array([vx, vy, vz, _yaw_rate(state, yaw_rad, target)])


def plan(state: VehicleState, gate: Gate) -> Segment:
    """Plan from the vehicle's state through the gate's centre, along its axis."""
    start, velocity = np.array(state.position_ned), np.array(state.velocity_ned)
    end = np.array(gate.centre_ned)
    axis = np.array([math.cos(gate.yaw_rad), math.sin(gate.yaw_rad), 0.0])
    min_s = max(MIN_DURATION_S, float(np.linalg.norm(end - start)) / MEAN_SPEED_M_S)
    for duration_s in np.arange(min_s, MAX_DURATION_S, DURATION_STEP_S):
        coefficients = _quintic(start, velocity, end, ARRIVAL_SPEED_M_S * axis, float(duration_s))
        segment = Segment(
            start_us=state.time_us, duration_s=float(duration_s), coefficients=coefficients
        )
        if _within_limits(segment):
            break
    return segment


def _quintic(
    start: NDArray[np.float64],
    start_velocity: NDArray[np.float64],
    end: NDArray[np.float64],
    end_velocity: NDArray[np.float64],
    duration_s: float,
) -> NDArray[np.float64]:
    """Coefficients (6, 3) between two states, with no acceleration at either end."""
    t = duration_s
    gap = end - start - start_velocity * t
    turn = (end_velocity - start_velocity) * t
    zero = np.zeros(3)
    return np.stack(
        [
            start,
            start_velocity,
            zero,
            (10.0 * gap - 4.0 * turn) / t**3,
            (-15.0 * gap + 7.0 * turn) / t**4,
            (6.0 * gap - 3.0 * turn) / t**5,
        ]
    )


def _within_limits(segment: Segment) -> bool:
    times = CHECKED_POINTS * segment.duration_s
    speeds = [np.linalg.norm(segment.at(float(t), derivative=1)) for t in times]
    accelerations = [np.linalg.norm(segment.at(float(t), derivative=2)) for t in times]
    return bool(max(speeds) <= MAX_SPEED_M_S and max(accelerations) <= MAX_ACCELERATION_M_S2)


def _yaw_rate(state: VehicleState, yaw_rad: float, gate: Gate) -> float:
    north = gate.centre_ned[0] - state.position_ned[0]
    east = gate.centre_ned[1] - state.position_ned[1]
    error = wrap_pi(math.atan2(east, north) - yaw_rad)
    return max(-MAX_YAW_RATE_RAD_S, min(MAX_YAW_RATE_RAD_S, YAW_GAIN_1_S * error))
