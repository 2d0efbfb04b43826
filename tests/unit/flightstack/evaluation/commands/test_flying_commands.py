"""What cannot be flown is said in one line, before anything is flown or written."""

from dataclasses import replace
from pathlib import Path

import pytest

from flightstack.evaluation import run
from flightstack.evaluation.campaign.folder import ROWS, Folder
from flightstack.evaluation.cli import main
from flightstack.evaluation.trials.experiment import Experiment
from flightstack.evaluation.trials.rows import TrialRow, to_line
from tests.unit.flightstack.evaluation.made_rows import ONE


@pytest.mark.parametrize(
    ("arguments", "code", "fragments"),
    [
        ("ladder --rungs sea", 2, ["unknown rung 'sea'", "level1"]),
        ("ladder --rungs fog fog", 2, ["condition fog", "twice"]),
        ("ladder --model nope/m9", 4, ["nope/m9", "strong/m0"]),
        ("ladder --strategy nope", 2, ["unknown strategy 'nope'", "mi-mode"]),
        ("ladder --tracks 0", 2, ["tracks must be 1 or more", "0"]),
        ("ladder --jobs 0", 2, ["--jobs must be 1 or more", "0"]),
        ("benchmark", 2, ["--policy, --perception, --strategy or --pilot"]),
        ("benchmark --policy nope:Nope", 2, ["policy 'nope:Nope'", "does not load"]),
        ("benchmark --strategy de-mean --trials 0", 2, ["trials must be 1 or more", "0"]),
        ("ablation --model nope/m9", 4, ["nope/m9"]),
        ("ablation --model strong/m0 --tracks 0", 2, ["tracks must be 1 or more"]),
        ("ablation --model strong/m0 --trials 0", 2, ["trials must be 1 or more, got 0"]),
        ("ablation --model strong/m0 --laps 0", 2, ["laps must be 1 or more, got 0"]),
        ("ablation --model strong/m0 --jobs 0", 2, ["--jobs must be 1 or more", "0"]),
        ("ablation --model strong/m0 --rungs fog fog", 2, ["condition fog", "twice"]),
        ("ablation --model strong/m0 --validation-tracks 0", 2, ["--validation-tracks", "got 0"]),
    ],
)
def test_what_cannot_be_flown_is_one_line(
    arguments: str,
    code: int,
    fragments: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(run, "fly", lambda *_, **__: pytest.fail("it flew"))
    out = tmp_path / "out"
    assert main([*arguments.split(), "--out", str(out)]) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert all(fragment in line for fragment in fragments)
    assert not out.exists()


@pytest.mark.parametrize(
    "arguments", ["ablation --model strong/m0", "ladder", "benchmark --strategy de-mean"]
)
def test_a_folder_of_something_else_is_left_alone(
    arguments: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "notes.txt").write_text("precious")
    assert main([*arguments.split(), "--out", str(tmp_path)]) == 2
    assert "choose another --out" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def flown_at_once(experiment: Experiment, folder: Folder, **_: object) -> list[TrialRow]:
    """Stand in for flights: fill the folder with rows of each trial."""
    rows = [
        replace(
            ONE,
            row=trial.row.name,
            condition=trial.condition.name,
            track_seed=trial.track_seed,
            experiment=experiment.name,
        )
        for trial in folder.missing
    ]
    with (folder.path / ROWS).open("a") as file:
        file.writelines(map(to_line, rows))
    return rows


def test_an_edited_policy_does_not_get_its_old_figures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(run, "fly", flown_at_once)
    monkeypatch.syspath_prepend(tmp_path)
    mine = tmp_path / "edited_policy.py"
    code = "class Good:\n    def __init__(self, **_): pass\n    def predict(self, z): return 1\n"
    mine.write_text(code)
    command = ["benchmark", "--policy=edited_policy:Good", "--against", "--rungs=level1"]
    command += ["--tracks=1", f"--out={tmp_path / 'out'}"]
    assert main(command) == 0
    mine.write_text(code.replace("return 1", "return 2"))
    assert main(command) == 2
    assert "holds another experiment (other code)" in capsys.readouterr().err
    assert main([*command, "--report-only"]) == 0
    assert main([*command, "--report-only", "--policy=other:Good"]) == 2
    assert "which says edited_policy:Good: leave it out" in capsys.readouterr().err
