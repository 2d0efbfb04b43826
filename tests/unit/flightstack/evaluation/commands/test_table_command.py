import shutil
from pathlib import Path

import pytest

from flightstack.evaluation.campaign.flying import models_of
from flightstack.evaluation.campaign.folder import Folder
from flightstack.evaluation.cli import main
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Experiment
from flightstack.evaluation.trials.rows import TrialRow, header_line, to_line
from flightstack.models import PACKAGE
from tests.unit.flightstack.evaluation.made_rows import ONE, made_row

STRONG = ("table", "--recipe=strong", "--rows", "m0-mean", "--tracks=2")


def two_tracks() -> Experiment:
    return Experiment(
        name="table",
        rows=paper.rows("strong", ("m0-mean",)),
        conditions=(paper.level("1"),),
        track_seeds=(1000, 1001),
        trials=1,
    )


def fill(folder: Path, *rows: TrialRow) -> None:
    (folder / "trials.csv").write_text(header_line() + "".join(map(to_line, rows)))


@pytest.mark.parametrize(
    ("options", "code", "said"),
    [
        (("--recipe=weak",), 4, "unknown model 'weak/m0'"),
        (("--rows=m7-mean",), 2, "unknown row 'm7-mean'"),
        (("--trials=0",), 2, "trials must be 1 or more, got 0"),
        (("--tracks=0",), 2, "tracks must be 1 or more, got 0"),
        (("--seeds=-1",), 2, "test tracks are 0 to 999999, got -1"),
        (("--laps=0",), 2, "laps must be 1 or more, got 0"),
        (("--jobs=0",), 2, "--jobs must be 1 or more, got 0"),
        (("--levels=3",), 2, "level '3'"),
        (("--levels=5,2",), 2, "level '5,2'"),
        (("--report-only",), 2, "cannot be read"),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(
    options: tuple[str, ...],
    code: int,
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = tmp_path / "out"
    assert main([*STRONG, *options, f"--out={out}"]) == code
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not out.exists()


def test_missing_weights_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "models" / "strong" / "m0"
    folder.mkdir(parents=True)
    shutil.copy(PACKAGE.parent / "models" / "strong" / "m0" / "config.toml", folder)
    monkeypatch.setenv("FLIGHTSTACK_MODELS", str(tmp_path / "models"))
    assert main([*STRONG, f"--out={tmp_path / 'out'}"]) == 4
    assert "weights.safetensors cannot be read: No such file" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_stands_is_told_and_who_flew_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    request = two_tracks()
    Folder(tmp_path, request, models_of(request))
    fill(tmp_path, made_row(4), made_row(9, track=1001))
    assert main([*STRONG, "--levels=1", f"--out={tmp_path}"]) == 0
    said = capsys.readouterr().err
    assert "2 trials stand already, 0 are to be flown\n" in said
    assert f"those that stand were flown by commit {ONE.commit}, not by " in said


def test_results_are_made_anew_from_rows_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Folder(tmp_path, two_tracks(), {})
    fill(tmp_path, ONE, made_row(4, track=1001))
    assert main([*STRONG, "--report-only", f"--out={tmp_path}"]) == 0
    assert "18.00" in capsys.readouterr().out
    assert "| m0-mean | 18.00 [" in (tmp_path / "results.md").read_text()
    assert (tmp_path / "results.json").exists()
