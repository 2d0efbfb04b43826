"""The folder of one experiment: what was requested, one row per trial, and their traces.

experiment.json  what was requested: another experiment's folder is refused
trials.csv       one row per trial, appended whole as they land, sorted at the end
times.csv        wall time of each trial, and the flights that died
traces/, logs/   the way of each trial; its tlog where that is requested
calibration/     of an ablation: what its controls were found by
"""

import csv
import fcntl
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from flightstack.errors import UsageError
from flightstack.evaluation.campaign.write_errors import write_errors_as_usage
from flightstack.evaluation.flights.flight import CompletedFlight, FlownTrial
from flightstack.evaluation.trials.experiment import Experiment, Key, Trial
from flightstack.evaluation.trials.request import REQUEST_FILE, check_same, request_table
from flightstack.evaluation.trials.rows import TrialRow, header_line, read_rows, to_line
from flightstack.files import write_whole

ROWS, TIMES = "trials.csv", "times.csv"
TRACES, LOGS = "traces", "logs"
CALIBRATION = "calibration"  # an experiment of its own, which some are laid out by
NO_CODE: Mapping[str, str] = {}
TIME_COLUMNS = ("trial", "wall_s", "flight_s", "simulated_s", "deaths")


class Folder:
    """An experiment's folder, ready to take rows."""

    def __init__(
        self,
        path: Path,
        experiment: Experiment,
        models: Mapping[str, str],
        code: Mapping[str, str] = NO_CODE,
    ) -> None:
        """Take it up where an earlier command left it.

        Raises UsageError where it holds anything but this experiment, by the same models
        (`models`: the SHA-256 of each one's configuration, which holds that of its weights) and
        the same code of others (`code`: the SHA-256 of each part that users bring); nothing is
        written then.
        """
        self.path = path
        self._experiment = experiment
        request = request_table(experiment, models, code)
        if (path / REQUEST_FILE).exists():
            check_same(path, request)
        elif path.exists():
            _check_free(path)
        self._flown = self._read() if (path / ROWS).exists() else {}
        with write_errors_as_usage():
            (path / TRACES).mkdir(parents=True, exist_ok=True)
            write_whole(path / REQUEST_FILE, json.dumps(request, indent=2) + "\n", durable=True)
            if not (path / ROWS).exists():
                write_whole(path / ROWS, header_line(), durable=True)

    @property
    def rows(self) -> list[TrialRow]:
        """All rows so far, in the order of the experiment: by row, condition, track and trial."""
        return in_order(self._experiment, self._flown.values())

    @property
    def missing(self) -> list[Trial]:
        """The trials that have no row yet."""
        return [trial for trial in self._experiment.plan() if trial.key not in self._flown]

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold it against another command; raises UsageError where one flies into it already."""
        with (self.path / REQUEST_FILE).open() as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise UsageError(f"another command is flying into {self.path}") from error
            self._flown = self._read()
            self.tidy()  # a line that was cut off goes
            yield

    def keep(self, flown: FlownTrial) -> None:
        """Write what came of a trial: its row last, so that a row stands for all of it."""
        with write_errors_as_usage():
            self._note_times(flown)
            if flown.flight is not None:
                self._keep_flight(flown.trial, flown.flight)

    def tidy(self) -> None:
        """Write the rows anew, in order."""
        with write_errors_as_usage():
            write_whole(
                self.path / ROWS, header_line() + "".join(map(to_line, self.rows)), durable=True
            )

    def _read(self) -> dict[Key, TrialRow]:
        return {row.key: row for row in read_trials(self.path, self._experiment)}

    def _keep_flight(self, trial: Trial, flight: CompletedFlight) -> None:
        flight.trace.save(self.path / TRACES / f"{trial}.npz")
        if flight.log is not None:
            (self.path / LOGS).mkdir(exist_ok=True)
            (self.path / LOGS / f"{trial}.tlog").write_bytes(flight.log)
        _append(self.path / ROWS, to_line(flight.row))
        self._flown[flight.row.key] = flight.row

    def _note_times(self, flown: FlownTrial) -> None:
        path = self.path / TIMES
        is_new = not path.exists()
        with path.open("a", newline="") as file:
            lines = csv.writer(file, lineterminator="\n")
            if is_new:
                lines.writerow(TIME_COLUMNS)
            flight = flown.flight
            times = (
                (flown.wall_s, 0.0, 0.0)
                if flight is None
                else (flown.wall_s, flight.flight_s, flight.simulated_s)
            )
            texts = (f"{time_s:.3f}" for time_s in times)
            lines.writerow([str(flown.trial), *texts, "; ".join(flown.deaths)])


def read_trials(path: Path, experiment: Experiment) -> list[TrialRow]:
    """Read the rows in the folder at `path`, in the order of the experiment.

    Raises UsageError where they cannot be read, or one is of no trial of this experiment.
    """
    rows = read_rows(path / ROWS)
    requested = {trial.key for trial in experiment.plan()}
    stranger = next((row for row in rows if row.key not in requested), None)
    if stranger is not None:
        name = "-".join(map(str, stranger.key))
        raise UsageError(f"{path / ROWS} is damaged: {REQUEST_FILE} asks for no trial {name}")
    return in_order(experiment, rows)


def in_order(experiment: Experiment, rows: Iterable[TrialRow]) -> list[TrialRow]:
    """Sort an experiment's rows as it names them: by row, condition, track and trial."""
    names = [row.name for row in experiment.rows]
    conditions = [condition.name for condition in experiment.conditions]
    return sorted(
        rows,
        key=lambda row: (
            names.index(row.row),
            conditions.index(row.condition),
            row.track_seed,
            row.trial,
        ),
    )


def calibration_folder(path: Path) -> Path:
    """Name the place of an experiment's calibration; raises UsageError where none may be."""
    calibration = path / CALIBRATION
    if (path / REQUEST_FILE).exists() and not calibration.exists():
        raise UsageError(f"{path} holds another experiment: choose another --out")
    if path.exists() and not (path / REQUEST_FILE).exists():
        _check_free(path)
    return calibration


def _check_free(path: Path) -> None:
    """Refuse a folder that holds more than what was flown to lay an experiment out."""
    if not path.is_dir() or any(entry.name != CALIBRATION for entry in path.iterdir()):
        raise UsageError(f"{path} is not empty and holds no experiment: choose another --out")


def _append(path: Path, line: str) -> None:
    with path.open("a", newline="") as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())
