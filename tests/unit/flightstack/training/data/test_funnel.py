"""The expert on a first-order vehicle: a velocity that lags half a second behind the command."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.frames import ned_from_body, wrap_pi
from flightstack.training.data.funnel import ExpertConfig, expert_command
from sitl import CourseState, make_track
from sitl.world.referee import Referee
from sitl.world.track import Track

LAG_S, STEP_S, SUBSTEPS = 0.5, 0.01, 5


def fly(
    track: Track, position: NDArray[np.float64], yaw: float, *, laps: int = 1, seconds: float = 60.0
) -> tuple[Referee, NDArray[np.float64]]:
    """Fly the track; returns the referee and the bearings (rad) of the gate that was due."""
    referee, config, gates = Referee(track.gates, laps), ExpertConfig(), track.gates
    velocity, bearings = np.zeros(3), []
    for _ in range(round(seconds / (STEP_S * SUBSTEPS))):
        due = referee.status.gates_passed
        gate = gates[due % 8]
        command = expert_command(tuple(position), yaw, gate, gates[(due + 1) % 8], config)
        asked = np.array(ned_from_body(tuple(command[:3]), yaw))
        start = position
        for _ in range(SUBSTEPS):
            velocity = velocity + (asked - velocity) * STEP_S / LAG_S
            position = position + velocity * STEP_S
            yaw += float(command[3]) * STEP_S
        to_gate = np.array(gate.centre_ned) - position
        if np.linalg.norm(to_gate) > 1.0:
            bearings.append(wrap_pi(math.atan2(to_gate[1], to_gate[0]) - yaw))
        referee.update(tuple(start), tuple(position), contact=False)
        if referee.status.state is not CourseState.ACTIVE:
            break
    return referee, np.abs(bearings)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("noise", [(0.0, 0.0), (1.0, 2.0), (1.5, 3.0)])
def test_passes_every_gate_and_keeps_the_next_in_view(
    seed: int, noise: tuple[float, float]
) -> None:
    track = make_track(seed, radius_noise_m=noise[0], height_noise_m=noise[1])
    referee, bearings = fly(track, np.array([0.0, 0.0, -3.0]), 0.0)
    assert referee.status.gates_passed == 8
    assert bearings.max() < math.radians(40.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_recovers_from_beside_the_gate(side: float) -> None:
    track = make_track(0)
    gate = track.gates[0]
    axis = np.array([math.cos(gate.yaw_rad), math.sin(gate.yaw_rad), 0.0])
    right = np.array([-axis[1], axis[0], 0.0])
    beside = np.array(gate.centre_ned) - 1.0 * axis + side * 1.0 * right
    referee, _ = fly(track, beside, gate.yaw_rad)
    assert referee.status.gates_passed == 8


def test_backs_off_rather_than_hit_the_frame() -> None:
    gate, following = make_track(0).gates[:2]
    axis = np.array([math.cos(gate.yaw_rad), math.sin(gate.yaw_rad), 0.0])
    right = np.array([-axis[1], axis[0], 0.0])
    at_the_bar = np.array(gate.centre_ned) - 0.3 * axis + 0.7 * right
    command = expert_command(tuple(at_the_bar), gate.yaw_rad, gate, following, ExpertConfig())
    assert command[0] < 0.0
    assert command[1] < -0.3
