"""Turn what a flight left behind, the companion's result and its log, into a trial's row."""

from dataclasses import dataclass
from pathlib import Path

from flightstack.evaluation.flights.trace import Trace, speeds
from flightstack.evaluation.flights.trial_request import GATE_LIMIT_S
from flightstack.evaluation.trials.experiment import Trial
from flightstack.evaluation.trials.rows import (
    COLLISION,
    FINISHED,
    MISSED,
    PARTS,
    TIMEOUT,
    TrialRow,
)
from flightstack.launch import FlightResult
from flightstack.logs import Log, read
from flightstack.logs.flight.course import find_events
from flightstack.logs.flight.decisions import Decisions, find_decisions
from flightstack.logs.flight.texts import status_texts
from flightstack.records import VELOCITIES

OUTCOMES = {  # the companion's words; others stay as they are
    "completed": FINISHED,
    "missed_gate": MISSED,
    "collision": COLLISION,
    "timeout": TIMEOUT,
}
VX = VELOCITIES.index("vx")
REFEREED = (MISSED, COLLISION)


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """What a row says of where it comes from."""

    experiment: str
    commit: str
    weights_sha256: str


def read_flight(
    trial: Trial, provenance: Provenance, result: FlightResult, log_path: Path
) -> tuple[TrialRow, Trace]:
    """Read the row, as if it were the first flight, and the trace."""
    log = read(log_path)
    decisions = find_decisions(log)
    outcome = OUTCOMES.get(result.outcome, result.outcome)
    row = TrialRow(
        experiment=provenance.experiment,
        row=trial.row.name,
        model=trial.row.model,
        strategy=trial.row.strategy,
        command_factor=trial.command_factor,
        condition=trial.condition.name,
        noise_radius_m=trial.condition.noise_m[0],
        noise_height_m=trial.condition.noise_m[1],
        direction=trial.condition.direction,
        track_seed=trial.track_seed,
        trial=trial.trial,
        seed=trial.seed,
        gates_passed=result.gates_passed,
        gates_total=result.gates_total or 0,
        outcome=outcome,
        failed_gate=None if outcome == FINISHED else result.gates_passed + 1,
        failure=_failure(log, outcome),
        duration_s=result.duration_s,
        retries=0,
        commit=provenance.commit,
        weights_sha256=provenance.weights_sha256,
        **_figures(log, decisions),
    )
    return row, Trace.of(log, decisions)


def _failure(log: Log, outcome: str) -> str:
    """Say what went wrong, in the referee's words where it judged."""
    if outcome in REFEREED:
        events = [event for event in find_events(status_texts(log)) if event.is_failure]
        return events[0].text if events else outcome
    if outcome == TIMEOUT:
        return f"no gate passed for {GATE_LIMIT_S:g} s, or out of time"
    return "" if outcome == FINISHED else outcome.replace("_", " ")


def _figures(log: Log, decisions: Decisions) -> dict[str, float]:
    """Average over the decisions; not a number where there was none."""
    if not len(decisions):
        names = [f"{part}_{velocity}" for part in PARTS for velocity in VELOCITIES]
        names += ["mean_speed_m_s", "command_vx_m_s", "multimodal_share"]
        return dict.fromkeys(names, float("nan"))
    stamps_us = decisions.stamp_us
    flown = speeds(log, int(stamps_us[0]), int(stamps_us[-1]))
    figures = {
        "mean_speed_m_s": float(flown.mean()) if len(flown) else float("nan"),
        "command_vx_m_s": float(decisions.command[:, VX].mean()),
        "multimodal_share": float((decisions.modes > 1).any(axis=1).mean()),
    }
    for part in PARTS:
        means = getattr(decisions, f"{part}_std").mean(axis=0)
        figures |= {
            f"{part}_{velocity}": float(mean)
            for velocity, mean in zip(VELOCITIES, means, strict=True)
        }
    return figures
