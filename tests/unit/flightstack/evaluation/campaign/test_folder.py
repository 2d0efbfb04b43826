import json
from pathlib import Path

import numpy as np
import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.campaign.folder import Folder, calibration_folder
from flightstack.evaluation.flights.flight import CompletedFlight, FlownTrial
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Experiment, Trial
from flightstack.evaluation.trials.rows import header_line, read_rows, to_line
from tests.unit.flightstack.evaluation.made_rows import made_row

MODELS = {"paper/m0": "ab" * 32}
TRACE = Trace(
    time_s=np.arange(2.0),
    position_ned=np.ones((2, 3)),
    uncertainty=np.full(2, 0.5),
    gates=np.zeros((8, 4)),
)


def experiment(trials: int = 1) -> Experiment:
    return Experiment(
        name="table",
        rows=paper.rows("paper", ("m0-mi-mode", "m0-mean")),
        conditions=(paper.level("1"),),
        track_seeds=(1000, 1001),
        trials=trials,
    )


def flown_trial(trial: Trial) -> FlownTrial:
    row = made_row(row=trial.row.name, track=trial.track_seed, trial=trial.trial)
    flight = CompletedFlight(row=row, trace=TRACE, log=b"log", simulated_s=40.0, flight_s=2.0)
    return FlownTrial(trial=trial, flight=flight, deaths=("killed",), wall_s=2.5)


def test_takes_up_where_it_was_left(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "out", experiment(), MODELS)
    first, *rest = folder.missing
    folder.keep(flown_trial(first))
    with (tmp_path / "out" / "trials.csv").open("a") as file:
        file.write(to_line(made_row(track=1001))[:30])  # the machine went down here
    again = Folder(tmp_path / "out", experiment(), MODELS)
    assert again.missing == rest
    with again.locked():
        for trial in reversed(rest):
            again.keep(flown_trial(trial))
        again.tidy()
    assert again.missing == []
    rows = read_rows(tmp_path / "out" / "trials.csv")
    assert [(row.row, row.track_seed) for row in rows] == [
        ("m0-mi-mode", 1000),
        ("m0-mi-mode", 1001),
        ("m0-mean", 1000),
        ("m0-mean", 1001),
    ]


def test_keeps_traces_logs_and_times(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "out", experiment(), MODELS)
    flown = flown_trial(folder.missing[0])
    folder.keep(flown)
    trace = Trace.load(tmp_path / "out" / "traces" / f"{flown.trial}.npz")
    assert np.array_equal(trace.position_ned, TRACE.position_ned)
    assert (tmp_path / "out" / "logs" / f"{flown.trial}.tlog").read_bytes() == b"log"
    assert (tmp_path / "out" / "times.csv").read_text().splitlines()[1] == (
        "m0-mi-mode-level1-1000-0,2.500,2.000,40.000,killed"
    )


def test_a_trial_that_only_died_stays_missing(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "out", experiment(), MODELS)
    trial = folder.missing[0]
    folder.keep(FlownTrial(trial=trial, flight=None, deaths=("killed",) * 3, wall_s=1.0))
    assert trial in folder.missing
    assert "killed; killed; killed" in (tmp_path / "out" / "times.csv").read_text()


@pytest.mark.parametrize(
    ("other", "models", "said"),
    [
        (experiment(trials=2), MODELS, "holds another experiment \\(other trials\\)"),
        (experiment(), {"paper/m0": "cd" * 32}, "holds another experiment \\(other models\\)"),
    ],
)
def test_refuses_the_folder_of_another_experiment(
    tmp_path: Path, other: Experiment, models: dict[str, str], said: str
) -> None:
    folder = Folder(tmp_path, experiment(), MODELS)
    folder.keep(flown_trial(folder.missing[0]))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    with pytest.raises(UsageError, match=said):
        Folder(tmp_path, other, models)
    assert before == {p.name: p.read_bytes() for p in tmp_path.iterdir() if p.is_file()}


def test_refuses_the_folder_of_other_code(tmp_path: Path) -> None:
    Folder(tmp_path, experiment(), MODELS, {"mine:Good": "ab"})
    Folder(tmp_path, experiment(), MODELS, {"mine:Good": "ab"})
    with pytest.raises(UsageError, match="holds another experiment \\(other code\\)"):
        Folder(tmp_path, experiment(), MODELS, {"mine:Good": "cd"})


def test_refuses_a_folder_of_other_things(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(UsageError, match="not empty and holds no experiment"):
        Folder(tmp_path, experiment(), MODELS)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize("text", ["", "[]", "null", '{"name": 3}', "{"])
def test_refuses_a_damaged_folder(tmp_path: Path, text: str) -> None:
    (tmp_path / "experiment.json").write_text(text)
    (tmp_path / "trials.csv").write_text(header_line())
    with pytest.raises(UsageError, match="choose another --out"):
        Folder(tmp_path, experiment(), MODELS)


def test_refuses_two_commands_at_once(tmp_path: Path) -> None:
    folder = Folder(tmp_path / "out", experiment(), MODELS)
    other = Folder(tmp_path / "out", experiment(), MODELS)
    refused = pytest.raises(UsageError, match="another command is flying")
    with folder.locked(), refused, other.locked():
        pass
    assert json.loads((tmp_path / "out" / "experiment.json").read_text())["laps"] == 4


def test_a_calibration_never_goes_into_what_is_not_its_own(tmp_path: Path) -> None:
    assert calibration_folder(tmp_path / "new") == tmp_path / "new" / "calibration"
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("precious")
    with pytest.raises(UsageError, match="is not empty and holds no experiment"):
        calibration_folder(tmp_path / "mine")
    (tmp_path / "table").mkdir()
    (tmp_path / "table" / "experiment.json").write_text("{}")
    with pytest.raises(UsageError, match="holds another experiment"):
        calibration_folder(tmp_path / "table")
    (tmp_path / "half" / "calibration").mkdir(parents=True)
    assert calibration_folder(tmp_path / "half").exists()
