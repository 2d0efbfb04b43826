"""Fly trials in parallel: by a process per core, by this process alone, or by a Ray cluster."""

import atexit
import contextlib
import functools
import multiprocessing
import signal
import tempfile
import time
from collections.abc import Generator, Iterable, Iterator
from pathlib import Path
from typing import Any

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightstack.evaluation.campaign import ray_backend
from flightstack.evaluation.campaign.interruption import ignoring_interrupts
from flightstack.evaluation.flights.flight import FlownTrial, TrialFlyer
from flightstack.evaluation.flights.reading import Provenance
from flightstack.evaluation.trials.experiment import Trial

LOKY, RAY = "loky", "ray"
WORKER_DIED = "a worker process died"
Assignment = tuple[Trial, Provenance]


class Workers:
    """Workers for a list of assignments: where one dies, all flights under way are lost."""

    def __init__(
        self, jobs: int, backend: str, *, keep_logs: bool, px4: Path | None = None
    ) -> None:
        # A trial is handed out when a worker is free for it: what is handed out is under way.
        self._settings: dict[str, Any] = {
            "n_jobs": jobs,
            "batch_size": 1,
            "pre_dispatch": "n_jobs",
            "return_as": "generator_unordered",
        }
        if backend == RAY:
            ray_backend.register()
            self._settings |= {"backend": ray_backend.NAME}
        self._keep_logs, self._px4 = keep_logs, px4
        self._began_s: dict[Trial, float] = {}  # of the flights under way, in monotonic time
        self.has_died = False

    def fly(self, assignments: Iterable[Assignment]) -> Generator[FlownTrial, None, None]:
        """Yield each trial as it lands; no more once `has_died`. Closing it ends all flights."""
        try:
            with contextlib.closing(self._flights(assignments)) as flights:
                for flown in flights:
                    self._began_s.pop(flown.trial)
                    yield flown
        except (TerminatedWorkerError, *ray_backend.worker_deaths()):
            self.has_died = True

    @property
    def lost(self) -> list[FlownTrial]:
        """The flights that a worker's death has ended."""
        now_s = time.monotonic()
        return [
            FlownTrial(trial=trial, flight=None, deaths=(WORKER_DIED,), wall_s=now_s - began_s)
            for trial, began_s in self._began_s.items()
        ]

    def _flights(self, assignments: Iterable[Assignment]) -> Generator[FlownTrial, None, None]:
        with tempfile.TemporaryDirectory(
            prefix="flightstack-trials-", ignore_cleanup_errors=True
        ) as scratch:  # here, not in the workers: those that are killed cannot tidy up
            try:
                with ignoring_interrupts():  # workers start here: a Ctrl-C is for the command alone
                    flights = Parallel(**self._settings)(
                        delayed(_fly_one)(assignment, scratch, self._keep_logs, self._px4)
                        for assignment in self._hand_out(assignments)
                    )
                yield from flights
            finally:
                _launcher(self._px4).close()  # which has flown where one job needs no worker

    def _hand_out(self, assignments: Iterable[Assignment]) -> Iterator[Assignment]:
        for assignment in assignments:
            self._began_s[assignment[0]] = time.monotonic()
            yield assignment


def _fly_one(
    assignment: Assignment,
    scratch: str,
    keep_log: bool,  # noqa: FBT001
    px4: Path | None,
) -> FlownTrial:
    trial, provenance = assignment
    launcher = _launcher(px4)
    launcher.scratch = Path(scratch) if Path(scratch).is_dir() else None  # on another machine
    return launcher.fly(trial, provenance, keep_log=keep_log)


@functools.cache
def _launcher(px4: Path | None) -> TrialFlyer:
    """Return this worker's own."""
    if multiprocessing.parent_process() is not None:  # one that was started late
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    launcher = TrialFlyer(px4=px4)
    atexit.register(launcher.close)
    return launcher
