"""The folder of one experiment: what was asked for, a row a trial, and their traces.

experiment.json  what was asked for: another experiment's folder is refused
trials.csv       one row a trial, appended whole as they land, sorted at the end
times.csv        wall time of each trial, and the flights that died
traces/, logs/   the way of each trial; its tlog where asked for
calibration/     of an ablation: what its controls were found by
"""

import csv
import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flightstack.errors import UsageError
from flightstack.evaluation.experiments.experiment import Experiment, Trial
from flightstack.evaluation.experiments.rows import TrialRow, header_line, read_rows, to_line
from flightstack.evaluation.flights.flight import Flown

ASKED, ROWS, TIMES = "experiment.json", "trials.csv", "times.csv"
TRACES, LOGS = "traces", "logs"
CALIBRATION = "calibration"  # an experiment of its own, which some are laid out by
NO_CODE: Mapping[str, str] = {}
NOTHING_BROUGHT: dict[str, object] = {
    "code": {}
}  # what a folder says that was made before it was asked
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
        the same code of others (`code`: the SHA-256 of each brought part's source); nothing is
        written then.
        """
        self.path = path
        self._experiment = experiment
        asked = json.loads(
            json.dumps({**experiment.as_table(), "models": dict(models), "code": dict(code)})
        )
        if (path / ASKED).exists():
            _check_same(path, asked)
        elif path.exists():
            _check_free(path)
        try:
            (path / TRACES).mkdir(parents=True, exist_ok=True)
            _write_whole(path / ASKED, json.dumps(asked, indent=2) + "\n")
            if not (path / ROWS).exists():
                _write_whole(path / ROWS, header_line())
        except OSError as error:
            raise UsageError(f"{path} cannot be written: {error.strerror}") from error
        self._flown = {row.key: row for row in read_rows(path / ROWS)}

    @property
    def rows(self) -> list[TrialRow]:
        """All rows so far, in the order of the experiment: by row, condition, track and trial."""
        rows = [row.name for row in self._experiment.rows]
        conditions = [condition.name for condition in self._experiment.conditions]
        return sorted(
            self._flown.values(),
            key=lambda row: (
                rows.index(row.row),
                conditions.index(row.condition),
                row.track_seed,
                row.trial,
            ),
        )

    @property
    def missing(self) -> list[Trial]:
        """The trials that have no row yet."""
        return [trial for trial in self._experiment.plan() if trial.key not in self._flown]

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold it against another command; raises UsageError where one flies into it already."""
        with (self.path / ASKED).open() as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise UsageError(f"another command is flying into {self.path}") from error
            self._flown = {row.key: row for row in read_rows(self.path / ROWS)}
            self.tidy()  # a line that was cut off goes
            yield

    def keep(self, flown: Flown) -> None:
        """Write what came of a trial: its row last, so that a row stands for all of it."""
        self._note_times(flown)
        landed = flown.landed
        if landed is None:
            return
        landed.trace.save(self.path / TRACES / f"{flown.trial}.npz")
        if landed.log is not None:
            (self.path / LOGS).mkdir(exist_ok=True)
            (self.path / LOGS / f"{flown.trial}.tlog").write_bytes(landed.log)
        _append(self.path / ROWS, to_line(landed.row))
        self._flown[landed.row.key] = landed.row

    def tidy(self) -> None:
        """Write the rows anew, in order."""
        _write_whole(self.path / ROWS, header_line() + "".join(map(to_line, self.rows)))

    def _note_times(self, flown: Flown) -> None:
        path = self.path / TIMES
        is_new = not path.exists()
        with path.open("a", newline="") as file:
            lines = csv.writer(file, lineterminator="\n")
            if is_new:
                lines.writerow(TIME_COLUMNS)
            landed = flown.landed
            times = (
                (flown.wall_s, 0.0, 0.0)
                if landed is None
                else (flown.wall_s, landed.flight_s, landed.simulated_s)
            )
            texts = (f"{time_s:.3f}" for time_s in times)
            lines.writerow([str(flown.trial), *texts, "; ".join(flown.deaths)])


def calibration_folder(path: Path) -> Path:
    """Name the place of an experiment's calibration; raises UsageError where none may be."""
    calibration = path / CALIBRATION
    if (path / ASKED).exists() and not calibration.exists():
        raise UsageError(f"{path} holds another experiment: choose another --out")
    if path.exists() and not (path / ASKED).exists():
        _check_free(path)
    return calibration


def _check_free(path: Path) -> None:
    """Refuse a folder that holds more than what was flown to lay an experiment out."""
    if not path.is_dir() or any(entry.name != CALIBRATION for entry in path.iterdir()):
        raise UsageError(f"{path} is not empty and holds no experiment: choose another --out")


def _check_same(path: Path, asked: dict[str, Any]) -> None:
    try:
        held = json.loads((path / ASKED).read_text())
    except (OSError, ValueError) as error:
        raise UsageError(f"{path / ASKED} cannot be read: choose another --out") from error
    known = NOTHING_BROUGHT | held if isinstance(held, dict) else {}
    if known == asked:
        return
    differing = ", ".join(key for key in asked if known.get(key) != asked[key])
    raise UsageError(
        f"{path} holds another experiment (other {differing or 'fields'}): choose another --out"
    )


def _append(path: Path, line: str) -> None:
    with path.open("a", newline="") as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def _write_whole(path: Path, text: str) -> None:
    """Replace a file at once, or leave it."""
    partial = path.with_name(path.name + ".partial")
    with partial.open("w", newline="") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    partial.replace(path)
