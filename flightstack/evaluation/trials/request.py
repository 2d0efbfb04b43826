"""experiment.json: what a folder's experiment requests, by which models and by whose code."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flightstack.errors import FlightstackError, UsageError
from flightstack.evaluation.trials.experiment import Experiment
from flightstack.tables import record_from_table

REQUEST_FILE = "experiment.json"
FIELDS = ("name", "rows", "conditions", "track_seeds", "trials", "laps")


def request_table(
    experiment: Experiment, models: Mapping[str, str], code: Mapping[str, str]
) -> dict[str, Any]:
    """Return what the file says, as JSON reads it; hashes as in `Folder`."""
    table = {**experiment.as_table(), "models": dict(models), "code": dict(code)}
    read: dict[str, Any] = json.loads(json.dumps(table))
    return read


def check_same(path: Path, request: dict[str, Any]) -> None:
    """Raise UsageError where the folder at `path` holds anything but what is requested."""
    held = _read(path)
    if held == request:
        return
    differing = ", ".join(key for key in request if held.get(key) != request[key])
    raise UsageError(
        f"{path} holds another experiment (other {differing or 'fields'}): choose another --out"
    )


def held_experiment(path: Path) -> Experiment:
    """Read which experiment the folder at `path` holds; raises UsageError where it tells none."""
    table = {name: value for name, value in _read(path).items() if name in FIELDS}
    try:
        return record_from_table(Experiment, table, where=str(path / REQUEST_FILE))
    except (ValueError, FlightstackError) as error:
        raise UsageError(f"{path / REQUEST_FILE} is damaged: {error}") from error


def _read(path: Path) -> dict[str, Any]:
    try:
        held = json.loads((path / REQUEST_FILE).read_text())
    except (OSError, ValueError) as error:
        raise UsageError(f"{path / REQUEST_FILE} cannot be read: choose another --out") from error
    if not isinstance(held, dict):
        raise UsageError(f"{path / REQUEST_FILE} is damaged: choose another --out")
    return held
