"""A trial as the request that `flightstack.launch` flies: all that a trial is, is in it."""

from pathlib import Path

from flightstack.evaluation.trials.experiment import Trial
from flightstack.launch.request import FlightRequest

GATE_LIMIT_S = 20.0  # vehicle time: gates are 6.1 m apart, 3 to 4 s at the usual speed


def request_of(trial: Trial, log: Path) -> FlightRequest:
    """Return the request; the companion's log goes to `log`."""
    condition, row = trial.condition, trial.row
    radius_m, height_m = condition.noise_m
    return FlightRequest(
        laps=trial.laps,
        track_seed=trial.track_seed,
        noise=f"{radius_m},{height_m}",
        model=row.model if row.pilot is None else None,
        strategy=row.strategy if row.pilot is None else None,
        speed_factor=0.0,
        vehicle_options=(
            *(f"--seed={trial.seed}", f"--direction={condition.direction}"),
            *condition.vehicle_options,
        ),
        companion_options=(
            *(f"--seed={trial.seed}", f"--direction={condition.direction}"),
            *(f"--speed-scale={trial.command_factor}", f"--gate-timeout={GATE_LIMIT_S}"),
            *("--no-landing", f"--log={log}", "--json", "--quiet"),
            *row.companion_options,
        ),
    )
