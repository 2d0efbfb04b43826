"""Fly the trials of an experiment in parallel, and keep a row of each."""

import atexit
import functools
import multiprocessing
import signal
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightstack import models
from flightstack.errors import FlightstackError, ModelError
from flightstack.evaluation.experiments import ray_backend
from flightstack.evaluation.experiments.experiment import Experiment, Trial
from flightstack.evaluation.experiments.folder import Folder
from flightstack.evaluation.experiments.progress import Progress
from flightstack.evaluation.experiments.rows import TrialRow
from flightstack.evaluation.experiments.version import commit
from flightstack.evaluation.flights.flight import Flown, Launcher
from flightstack.evaluation.flights.reading import Provenance

LOKY, RAY = "loky", "ray"
Order = tuple[Trial, Provenance]
WORKER_DEATHS = 3


class UnflownError(FlightstackError):
    """Some trials died in every attempt: their rows are missing."""


def models_of(experiment: Experiment) -> dict[str, str]:
    """Hash the configuration of every model, which also says how its variances are calibrated.

    Raises ModelError where a model is unknown, or its weights are damaged.
    """
    names = _weights_of(experiment)
    return {name: models.file_sha256(models.find(name) / models.CONFIG_FILE) for name in names}


def fly(
    experiment: Experiment, folder: Folder, *, jobs: int, backend: str = LOKY, keep_logs: bool
) -> list[TrialRow]:
    """Fly all trials that the folder lacks; returns all rows, which do not depend on `jobs`.

    Raises UnflownError after all others are flown, where trials died in every attempt.
    """
    weights = _weights_of(experiment)
    version = commit()
    dead: list[Flown] = []
    with folder.locked(), Progress(len(folder.missing), len(folder.rows)) as progress:
        _tell_other_commits(folder.rows, version, progress)
        for _ in range(WORKER_DEATHS):
            given_up = {flown.trial.key for flown in dead}
            trials = [trial for trial in folder.missing if trial.key not in given_up]
            orders = ((trial, _provenance(experiment, trial, weights, version)) for trial in trials)
            try:
                for flown in _in_parallel(orders, jobs, backend, keep_logs=keep_logs):
                    folder.keep(flown)
                    progress.note(flown)
                    if flown.landed is None:
                        dead.append(flown)
            except (TerminatedWorkerError, *ray_backend.worker_deaths()):
                progress.say("a worker process died: its trials are flown again")
                continue
            break
        folder.tidy()
    if folder.missing:
        raise UnflownError(
            f"{len(folder.missing)} trials died in every attempt, such as {folder.missing[0]} "
            f"(see {folder.path / 'times.csv'}): run the same command again"
        )
    return folder.rows


def _tell_other_commits(standing: Iterable[TrialRow], today: str, progress: Progress) -> None:
    others = sorted({row.commit for row in standing} - {today})
    if others:
        progress.say(f"those that stand were flown by commit {', '.join(others)}, not by {today}")


def _in_parallel(
    orders: Iterable[Order], jobs: int, backend: str, *, keep_logs: bool
) -> Iterator[Flown]:
    settings: dict[str, Any] = {"n_jobs": jobs, "batch_size": 1, "pre_dispatch": "2*n_jobs"}
    if backend == RAY:
        ray_backend.register()
        settings |= {"backend": ray_backend.NAME}
    parallel = Parallel(return_as="generator_unordered", **settings)
    with tempfile.TemporaryDirectory(
        prefix="flightstack-trials-", ignore_cleanup_errors=True
    ) as scratch:  # here, not in the workers: those that are killed cannot tidy up
        try:
            yield from parallel(delayed(_fly_one)(order, scratch, keep_logs) for order in orders)
        finally:
            _launcher().close()  # which has flown where one job needs no worker


def _fly_one(order: Order, scratch: str, keep_log: bool) -> Flown:  # noqa: FBT001
    trial, provenance = order
    launcher = _launcher()
    launcher.scratch = Path(scratch) if Path(scratch).is_dir() else None  # on another machine
    return launcher.fly(trial, provenance, keep_log=keep_log)


@functools.cache
def _launcher() -> Launcher:
    """Return this worker's own."""
    if multiprocessing.parent_process() is not None:  # a Ctrl-C is for the command alone
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    launcher = Launcher()
    atexit.register(launcher.close)
    return launcher


def _provenance(
    experiment: Experiment, trial: Trial, weights: dict[str, str], version: str
) -> Provenance:
    return Provenance(
        experiment=experiment.name, commit=version, weights_sha256=weights[trial.row.model]
    )


def _weights_of(experiment: Experiment) -> dict[str, str]:
    return {row.model: _checked_sha256(row.model) for row in experiment.rows}


def _checked_sha256(name: str) -> str:
    folder = models.find(name)
    recorded = models.read_config(folder / models.CONFIG_FILE).weights_sha256
    path = folder / models.WEIGHTS_FILE
    try:
        found = models.file_sha256(path)
    except OSError as error:
        raise ModelError(f"{path} cannot be read: {error.strerror}") from error
    if found != recorded:
        raise ModelError(f"{path} is damaged: its hash is not what {models.CONFIG_FILE} records")
    return recorded
