"""Spell out the command lines of a trial's two processes: all that a trial is, is in them."""

from pathlib import Path

from flightstack.evaluation.flights.ports import Ports
from flightstack.evaluation.trials.experiment import Trial

LAP_LIMIT_S = 90.0  # vehicle time
GATE_LIMIT_S = 20.0  # vehicle time: gates are 6.1 m apart, 3 to 4 s at the usual speed
LOG = "companion.tlog"


def vehicle_arguments(trial: Trial, ports: Ports) -> list[str]:
    """Arguments of `python -m sitl`."""
    radius_m, height_m = trial.condition.noise_m
    return [
        *("--lockstep", "--speed-factor=0", f"--laps={trial.laps}"),
        *(f"--seed={trial.seed}", f"--track-seed={trial.track_seed}"),
        *(f"--noise={radius_m},{height_m}", f"--direction={trial.condition.direction}"),
        f"--gcs-link={ports.gcs_local}:{ports.gcs_remote}",
        f"--api-link={ports.api_local}:{ports.api_remote}",
        f"--camera-port={ports.camera}",
        *trial.condition.vehicle_options,
    ]


def companion_arguments(trial: Trial, ports: Ports, folder: Path) -> list[str]:
    """Arguments of `python -m flightstack.companion`."""
    return [
        *(f"--udp={ports.api_remote}", f"--seed={trial.seed}"),
        *(f"--model={trial.row.model}", f"--strategy={trial.row.strategy}"),
        f"--direction={trial.condition.direction}",
        f"--speed-scale={trial.command_factor}",
        *(f"--duration={LAP_LIMIT_S * trial.laps}", f"--gate-timeout={GATE_LIMIT_S}"),
        *("--no-landing", f"--log={folder / LOG}", "--json", "--quiet"),
        *trial.row.companion_options,
    ]
