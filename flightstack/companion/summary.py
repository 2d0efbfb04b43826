"""Say what a flight came to: for people, as JSON, and as an exit code."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flightstack.companion.mission.records import Outcome

EXIT_CODES = {
    Outcome.COMPLETED: 0,
    Outcome.CAMERA_LOST: 3,
    Outcome.LINK_LOST: 3,
    Outcome.RESTARTED: 3,
    Outcome.INTERRUPTED: 130,
}
MISSION_FAILED = 1
SENTENCES = {
    Outcome.COMPLETED: "completed",
    Outcome.MISSED_GATE: "ended by a missed gate",
    Outcome.COLLISION: "ended by a collision",
    Outcome.TIMEOUT: "ended by its time limit",
    Outcome.TAKEN_OVER: "taken over: the vehicle left offboard",
    Outcome.COURSE_OVER: "not flown: the vehicle's course is over already, restart the vehicle",
    Outcome.REFUSED: "not done: the vehicle did not do as asked",
    Outcome.INTERRUPTED: "interrupted",
    Outcome.CAMERA_LOST: "camera lost",
    Outcome.LINK_LOST: "vehicle lost: it was silent",
    Outcome.RESTARTED: "the vehicle has restarted",
    Outcome.FOUND_ARMED: "not flown: the vehicle was armed already, --take-over goes on with it",
    Outcome.OTHER_PILOT: "let go: somebody else steers the vehicle, --take-over insists",
    Outcome.PART_FAILED: "landed: a part of the pilot failed",
    Outcome.OUT_OF_LIMITS: "landed: the vehicle was outside its limits",
    Outcome.COMPANION_FAILED: "landed: an error of the companion's own",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSummary:
    """What happened on one flight."""

    outcome: Outcome
    gates_passed: int
    gates_total: int | None  # None where nobody judges
    duration_s: float  # vehicle time from offboard to the end
    log: Path
    real_time_factor: float
    latencies_s: tuple[float, ...]  # wall time from an image to its setpoint, in flight
    images: int
    setpoints: int

    @property
    def exit_code(self) -> int:
        """The process's exit code."""
        return EXIT_CODES.get(self.outcome, MISSION_FAILED)

    def to_json(self, *, model: str, strategy: str) -> str:
        """Write one JSON object on one line, with the names of what flew."""
        return json.dumps(
            {
                "gates_passed": self.gates_passed,
                "gates_total": self.gates_total,
                "outcome": self.outcome.value,
                "duration_s": round(self.duration_s, 3),
                "log": str(self.log),
                "model": model,
                "strategy": strategy,
                "real_time_factor": round(self.real_time_factor, 2),
                "latency_ms": {"p50": self._latency_ms(50), "p99": self._latency_ms(99)},
                "frames": self.images,
                "setpoints": self.setpoints,
            }
        )

    def to_text(self) -> str:
        """Write two lines for people."""
        gates = (
            "" if self.gates_total is None else f"{self.gates_passed} of {self.gates_total} gates, "
        )
        latency = self._latency_ms(99)
        timing = "" if latency is None else f", frame to setpoint {latency:g} ms (99 %)"
        return (
            f"{SENTENCES[self.outcome]}: {gates}{self.duration_s:.1f} s in offboard "
            f"at {self.real_time_factor:.1f}x real time{timing}\nlog: {self.log}"
        )

    def _latency_ms(self, percent: float) -> float | None:
        if not self.latencies_s:
            return None
        return round(1000 * float(np.percentile(self.latencies_s, percent)), 2)
