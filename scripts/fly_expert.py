"""Fly the funnel expert, who knows where gates and vehicle are: what imitating it can be worth.

    python scripts/fly_expert.py [--tracks 10] [--noise 1.5,3.0] [--laps 4] [--rotor-noise 0]
                                 [--speed 2.0] [--look-ahead 1.8] [--look-ahead-share 0.7]
                                 [--blind 0]

Flies validation tracks in process and prints the gates that were passed. `--rotor-noise` shakes
the estimate by which the vehicle holds its velocity. `--blind` keeps the expert from correcting
anything over the last metres before a gate, where a camera that looks ahead sees no more of it.
"""

import argparse
import math
import statistics
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightstack.frames import body_from_ned, ned_from_body
from flightstack.training.data.funnel import ExpertConfig, FunnelExpert
from flightstack.training.seeds import VALIDATION_TRACKS
from sitl import (
    GATE_HEIGHT_M,
    GATES_PER_LAP,
    Conditions,
    CourseState,
    EstimateErrors,
    Gate,
    OffboardSetpoint,
    Simulation,
    SimulationConfig,
    SitlError,
    VehicleState,
    yaw_of,
)

LONGEST_S = 200.0  # of a flight: four laps at 1 m/s


class BlindExpert:
    """The expert, who over the last metres before a gate flies straight along its axis."""

    def __init__(self, config: ExpertConfig, blind_m: float) -> None:
        self._expert, self._speed_m_s = FunnelExpert(config), config.speed_m_s
        self._blind_m = blind_m

    def command(self, state: VehicleState, gate: Gate, following: Gate) -> NDArray[np.float64]:
        """Command (4,) for a state: vx, vy, vz (m/s, yaw-aligned body), yaw rate (rad/s)."""
        command = self._expert.command(state, gate, following)
        north, east = math.cos(gate.yaw_rad), math.sin(gate.yaw_rad)
        centre, position = gate.centre_ned, state.position_ned
        ahead_m = north * (centre[0] - position[0]) + east * (centre[1] - position[1])
        if ahead_m < self._blind_m:
            along = (self._speed_m_s * north, self._speed_m_s * east, 0.0)
            command[:3] = body_from_ned(along, yaw_of(state.q_ned_frd))
        return command


def fly(config: SimulationConfig, expert: BlindExpert) -> int:
    """Fly one course; how many gates were passed."""
    simulation = Simulation(config)
    try:
        simulation.start_airborne((0.0, 0.0, -GATE_HEIGHT_M), 0.0)
        gates = simulation.course_gates
        while simulation.course.state is CourseState.ACTIVE:
            if simulation.time_us > LONGEST_S * 1e6:
                break
            if simulation.image_due():
                due = simulation.course.gates_passed
                gate, following = gates[due % len(gates)], gates[(due + 1) % len(gates)]
                _steer(simulation, expert.command(simulation.state, gate, following))
            simulation.step()
        return simulation.course.gates_passed
    finally:
        simulation.close()


def _steer(simulation: Simulation, command: NDArray[np.float64]) -> None:
    vx, vy, vz, yaw_rate = command.tolist()
    simulation.autopilot.offboard_setpoint(
        OffboardSetpoint(
            time_us=simulation.time_us,
            velocity_ned=ned_from_body((vx, vy, vz), yaw_of(simulation.state.q_ned_frd)),
            yaw_rate_rad_s=yaw_rate,
        )
    )


def _within(low: float, high: float) -> Callable[[str], float]:
    """Make what reads a number from the command line."""

    def read(text: str) -> float:
        value = float(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text}: expected {low:g} to {high:g}")
        return value

    return read


def _noise(text: str) -> tuple[float, float]:
    """Read GRN,GHN in m; the course says what may be."""
    radius_m, height_m = (float(figure) for figure in text.split(","))
    return radius_m, height_m


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    add, usual, share = parser.add_argument, ExpertConfig(), _within(0.0, 1.0)
    add("--tracks", type=int, choices=range(1, 1001), default=10, metavar="N")
    add("--noise", type=_noise, default=(1.5, 3.0), metavar="GRN,GHN", help="of the gates, m")
    add("--laps", type=int, choices=range(1, 101), default=4, metavar="N")
    add("--rotor-noise", type=share, default=0.0, metavar="SHARE", help="1: as in PX4's simulator")
    add("--speed", type=_within(0.1, 5.0), default=usual.speed_m_s, metavar="M/S")
    add("--look-ahead", type=_within(0.1, 10.0), default=usual.look_ahead_m, metavar="M")
    add("--look-ahead-share", type=share, default=usual.look_ahead_share, metavar="SHARE")
    add("--blind", type=_within(0.0, 5.0), default=0.0, metavar="M", help="before each gate")
    return parser


def main() -> None:
    """Fly, and print."""
    options = _parser().parse_args()
    expert = BlindExpert(
        ExpertConfig(
            speed_m_s=options.speed,
            look_ahead_m=options.look_ahead,
            look_ahead_share=options.look_ahead_share,
        ),
        options.blind,
    )
    conditions = Conditions(estimate=EstimateErrors(rotor_noise_share=options.rotor_noise))
    try:
        config = SimulationConfig(noise_m=options.noise, laps=options.laps, conditions=conditions)
        passed = [
            fly(replace(config, seed=k, track_seed=VALIDATION_TRACKS.start + k), expert)
            for k in range(options.tracks)
        ]
    except SitlError as error:
        sys.exit(f"fly_expert.py: {error}")
    print("gates passed:", *passed)
    print(f"mean: {statistics.mean(passed):.1f} of {options.laps * GATES_PER_LAP}")


if __name__ == "__main__":
    main()
