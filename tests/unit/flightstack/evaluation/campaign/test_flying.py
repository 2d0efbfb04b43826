"""Flights are kept, and those that a worker's death ended are flown again and said so."""

import csv
import os
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from joblib.externals.loky.process_executor import TerminatedWorkerError

from flightstack.evaluation.campaign import workers
from flightstack.evaluation.campaign.flying import UnflownError, fly
from flightstack.evaluation.campaign.folder import Folder
from flightstack.evaluation.campaign.interruption import interrupted_once
from flightstack.evaluation.flights.flight import CompletedFlight, FlownTrial
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.results.markdown import footnotes
from flightstack.evaluation.results.summary import summarise
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Experiment
from tests.unit.flightstack.evaluation.made_rows import made_row

TRACE = Trace(
    time_s=np.arange(2.0),
    position_ned=np.ones((2, 3)),
    uncertainty=np.full(2, 0.5),
    gates=np.zeros((8, 4)),
)
REQUEST_FILE = Experiment(
    name="table",
    rows=paper.rows("strong", ("m0-mean",)),
    conditions=(paper.level("1"),),
    track_seeds=(1000, 1001, 1002),
    trials=1,
)


def land(order: workers.Assignment, *_how: object) -> FlownTrial:
    """Fly at once; the first track's flight dies of itself, once."""
    trial, _ = order
    deaths = ("killed",) if trial.track_seed == 1000 else ()
    row = replace(made_row(track=trial.track_seed), retries=len(deaths))
    flight = CompletedFlight(row=row, trace=TRACE, log=None, simulated_s=40.0, flight_s=2.0)
    return FlownTrial(trial=trial, flight=flight, deaths=deaths, wall_s=2.5)


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path / "out", REQUEST_FILE, {})


def times(folder: Folder) -> list[tuple[str, str]]:
    with (folder.path / "times.csv").open(newline="") as file:
        return [(line["trial"], line["deaths"]) for line in csv.DictReader(file)]


def workers_die(monkeypatch: pytest.MonkeyPatch, *, track: int, count: int) -> None:
    """Kill the worker that flies this track so often."""
    left = [count]

    def flown(order: workers.Assignment, *_how: object) -> FlownTrial:
        if order[0].track_seed == track and left[0]:
            left[0] -= 1
            raise TerminatedWorkerError
        return land(order)

    monkeypatch.setattr(workers, "_fly_one", flown)


def test_a_workers_death_is_noted_and_counted(
    folder: Folder, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    workers_die(monkeypatch, track=1001, count=2)
    rows = fly(REQUEST_FILE, folder, jobs=1, keep_logs=False)
    assert [(row.track_seed, row.retries) for row in rows] == [(1000, 1), (1001, 2), (1002, 0)]
    assert times(folder) == [
        ("m0-mean-level1-1000-0", "killed"),
        ("m0-mean-level1-1001-0", "a worker process died"),
        ("m0-mean-level1-1001-0", "a worker process died"),
        ("m0-mean-level1-1001-0", ""),
        ("m0-mean-level1-1002-0", ""),
    ]
    assert capsys.readouterr().err.count("a worker process died: its trials are flown again") == 2
    assert "3 flights died and were flown again" in footnotes(summarise(rows))


def test_a_trial_whose_worker_always_dies_is_named(
    folder: Folder, monkeypatch: pytest.MonkeyPatch
) -> None:
    workers_die(monkeypatch, track=1002, count=9)
    with pytest.raises(UnflownError, match="1 trials died in every attempt, such as m0-mean-lev"):
        fly(REQUEST_FILE, folder, jobs=1, keep_logs=False)
    assert [row.track_seed for row in folder.rows] == [1000, 1001]
    assert times(folder)[2:] == [("m0-mean-level1-1002-0", "a worker process died")] * 3


@pytest.mark.parametrize(
    ("number", "raised"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, SystemExit)]
)
def test_only_the_first_signal_stops(number: int, raised: type[BaseException]) -> None:
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        with pytest.raises(raised), interrupted_once():
            os.kill(os.getpid(), number)
        os.kill(os.getpid(), signal.SIGINT)  # while all is tidied up
        os.kill(os.getpid(), signal.SIGTERM)
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def test_signals_are_as_before_where_nothing_stopped() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interrupted_once():
        assert signal.getsignal(signal.SIGINT) != before
    assert signal.getsignal(signal.SIGINT) == before
