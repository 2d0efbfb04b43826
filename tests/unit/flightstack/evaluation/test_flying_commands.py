"""What cannot be flown is said in one line, before anything is flown or written."""

from pathlib import Path

import pytest

from flightstack.evaluation.cli import main


@pytest.mark.parametrize(
    ("arguments", "code", "fragments"),
    [
        ("ladder --rungs sea", 2, ["unknown rung 'sea'", "level1"]),
        ("ladder --rungs fog fog", 2, ["condition fog", "twice"]),
        ("ladder --model nope/m9", 4, ["nope/m9", "strong/m0"]),
        ("ladder --strategy nope", 2, ["unknown strategy 'nope'", "mi-mode"]),
        ("ladder --tracks 0", 2, ["tracks must be 1 or more", "0"]),
        ("ladder --jobs 0", 2, ["--jobs must be 1 or more", "0"]),
        ("benchmark", 2, ["--policy, --perception or --strategy"]),
        ("benchmark --policy nope:Nope", 2, ["policy 'nope:Nope'", "does not load"]),
        ("benchmark --strategy de-mean --trials 0", 2, ["trials must be 1 or more", "0"]),
        ("ablation --model nope/m9", 4, ["nope/m9"]),
        ("ablation --model strong/m0 --tracks 0", 2, ["tracks must be 1 or more"]),
        ("ablation --model strong/m0 --validation-tracks 0", 2, ["--validation-tracks", "got 0"]),
    ],
)
def test_what_cannot_be_flown_is_one_line(
    arguments: str,
    code: int,
    fragments: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
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
