"""Fly the trials of an experiment in parallel, and keep a row of each."""

import contextlib
from collections import Counter
from pathlib import Path

from flightstack import models
from flightstack.errors import FlightstackError, ModelError
from flightstack.evaluation.campaign.folder import Folder
from flightstack.evaluation.campaign.interruption import interrupted_once
from flightstack.evaluation.campaign.progress import TrialProgress
from flightstack.evaluation.campaign.workers import LOKY, WORKER_DIED, Workers
from flightstack.evaluation.flights.reading import Provenance
from flightstack.evaluation.trials.experiment import Experiment, Key, Trial
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.evaluation.trials.version import commit

WORKER_DEATHS = 3


class UnflownError(FlightstackError):
    """Some trials died in every attempt: their rows are missing."""


def models_of(experiment: Experiment) -> dict[str, str]:
    """Hash the configuration of every model, which also says how its variances are calibrated.

    Raises ModelError where a model is unknown, or its weights are damaged.
    """
    names = [model for model, weights in _weights_of(experiment).items() if weights]
    return {name: models.file_sha256(models.find(name) / models.CONFIG_FILE) for name in names}


def fly(
    experiment: Experiment,
    folder: Folder,
    *,
    jobs: int,
    backend: str = LOKY,
    keep_logs: bool,
    px4: Path | None = None,
) -> list[TrialRow]:
    """Fly all trials that the folder lacks; returns all rows, which do not depend on `jobs`.

    `px4` is a real one, which flies in place of the emulated autopilot. Raises UnflownError after
    all others are flown, where trials died in every attempt.
    """
    weights, version = _weights_of(experiment), commit()
    losses: Counter[Key] = Counter()  # of flights, by the death of a worker
    given_up: set[Key] = set()
    with interrupted_once(), folder.locked(), _progress(folder, version) as progress:
        for _ in range(WORKER_DEATHS):
            trials = [trial for trial in folder.missing if trial.key not in given_up]
            if not trials:
                break
            workers = Workers(jobs, backend, keep_logs=keep_logs, px4=px4)
            assignments = (
                (trial, _provenance(experiment, trial, weights, version)) for trial in trials
            )
            with contextlib.closing(workers.fly(assignments)) as flights:
                for flown in flights:
                    folder.keep(flown.after(losses[flown.trial.key]))
                    progress.note(flown)
                    given_up |= {flown.trial.key} if flown.flight is None else set()
            if workers.has_died:
                progress.say(f"{WORKER_DIED}: its trials are flown again")
            for flown in workers.lost:
                folder.keep(flown)
                losses[flown.trial.key] += 1
        folder.tidy()
    if folder.missing:
        raise UnflownError(
            f"{len(folder.missing)} trials died in every attempt, such as {folder.missing[0]} "
            f"(see {folder.path / 'times.csv'}): run the same command again"
        )
    return folder.rows


def _progress(folder: Folder, today: str) -> TrialProgress:
    """Begin to count; tell where rows that stand are of other commits than today's."""
    progress = TrialProgress(len(folder.missing), len(folder.rows))
    others = sorted({row.commit for row in folder.rows} - {today})
    if others:
        progress.say(f"those that stand were flown by commit {', '.join(others)}, not by {today}")
    return progress


def _provenance(
    experiment: Experiment, trial: Trial, weights: dict[str, str], version: str
) -> Provenance:
    return Provenance(
        experiment=experiment.name, commit=version, weights_sha256=weights[trial.row.model]
    )


def _weights_of(experiment: Experiment) -> dict[str, str]:
    """Return the hash of each row's weights; a pilot of a user's own is told by its code alone."""
    return {
        row.model: _checked_sha256(row.model) if row.pilot is None else ""
        for row in experiment.rows
    }


def _checked_sha256(name: str) -> str:
    folder = models.find(name)
    recorded = models.recorded(name).weights_sha256
    path = folder / models.WEIGHTS_FILE
    try:
        found = models.file_sha256(path)
    except OSError as error:
        raise ModelError(f"{path} cannot be read: {error.strerror}") from error
    if found != recorded:
        raise ModelError(f"{path} is damaged: its hash is not what {models.CONFIG_FILE} records")
    return recorded
