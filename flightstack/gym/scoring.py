"""What an image's flight is rewarded by, and when an episode ends.

    +1      for each gate passed
    -1      at its end by a missed gate, by a collision, or near the ground
    +0.1    for each metre by which the next gate has come nearer, negative if it went away

It terminates after the last gate, after a miss or a collision as the referee sees them, and below
0.3 m, where the companion would hold and land. It is truncated 20 s after the last gate that was
passed, as the trials of flightstack.evaluation are, and 90 s a lap after the start.
"""

from dataclasses import dataclass
from typing import Self

from flightstack.gym.flight import GateFlight
from flightstack.launch.request import LAP_LIMIT_S
from sitl import GATES_PER_LAP, CourseState

GATE_LIMIT_S = 20.0
MIN_HEIGHT_M = 0.3
COMPLETED, NEAR_GROUND, TIMEOUT = "completed", "near_ground", "timeout"
OUTCOMES = {"missed": "missed_gate", "collision": "collision"}  # by what the referee saw


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What came of the flight up to an image."""

    reward: float = 0.0  # since the image before
    gates_passed: int = 0
    gate_s: float = 0.0  # when the last one was passed
    distance_m: float = 0.0  # to the one that is due
    outcome: str = ""  # while it flies
    terminated: bool = False
    truncated: bool = False

    @classmethod
    def at_start(cls, flight: GateFlight) -> Self:
        """Return that of a flight that has just begun."""
        return cls(distance_m=flight.distance_m, gate_s=flight.elapsed_s)


def judge(before: Score, flight: GateFlight, *, progress_reward: float) -> Score:
    """Judge what has been flown since the image before."""
    passed, total = flight.gates
    distance_m = flight.distance_m
    new = passed - before.gates_passed
    gate_s = flight.elapsed_s if new else before.gate_s
    outcome = _outcome(flight, gate_s, laps=total // GATES_PER_LAP)
    failed = outcome not in ("", COMPLETED, TIMEOUT)
    progress_m = 0.0 if new else before.distance_m - distance_m
    return Score(
        reward=new - failed + progress_reward * progress_m,
        gates_passed=passed,
        gate_s=gate_s,
        distance_m=distance_m,
        outcome=outcome,
        terminated=failed or outcome == COMPLETED,
        truncated=outcome == TIMEOUT,
    )


def _outcome(flight: GateFlight, gate_s: float, *, laps: int) -> str:
    events = flight.drain_events()
    if flight.state is CourseState.FINISHED:
        return COMPLETED
    if flight.state is CourseState.FAILED:
        return next((OUTCOMES[event] for event in events if event in OUTCOMES), "failed")
    if flight.height_m < MIN_HEIGHT_M:
        return NEAR_GROUND
    late = flight.elapsed_s - gate_s > GATE_LIMIT_S or flight.elapsed_s > LAP_LIMIT_S * laps
    return TIMEOUT if late else ""
