"""A report is made of what the folder says, and of nothing that it does not hold."""

import json
import shutil
from pathlib import Path

import pytest

from flightstack import models
from flightstack.evaluation.cli import main
from tests.paths import DOCS

RESULTS = DOCS / "results"


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def today(name: str) -> str:
    """The hash of a model's configuration as it stands now."""
    return models.file_sha256(models.find(name) / models.CONFIG_FILE)


def report(command: str, out: Path) -> int:
    return main([*command.split(), "--report-only", "--out", str(out)])


@pytest.mark.parametrize(
    ("command", "name", "told"),
    [
        ("table", "table-strong", "# Table II, recipe strong"),
        ("table --recipe strong --tracks 6 --levels 1 2", "table-strong", "recipe strong"),
        ("ladder", "ladder-strong-m0", "- **fog**: "),
        ("ladder --tracks 6 --model strong/m0", "ladder-strong-m0", "- **fog**: "),
        ("ablation", "ablation-paper", "# What makes the effect of mi-mode, paper/m0"),
        ("ablation", "factorial-paper", "## Each level against the plain one"),
        ("ablation --factorial", "factorial-paper", "## Each level against the plain one"),
    ],
)
def test_published_folders_are_reported(command: str, name: str, told: str, out: Path) -> None:
    shutil.copytree(RESULTS / name, out)
    assert report(command, out) == 0
    assert told in (out / "results.md").read_text()


@pytest.mark.parametrize(
    ("command", "name", "said"),
    [
        ("table --recipe paper", "table-strong", "--recipe contradicts"),
        ("table --rows m0-mean", "table-strong", "which says m0-mean, m0-mi-mode, m1-mean"),
        ("table --levels 1", "table-strong", "which says level1, level2"),
        ("table --trials 1", "table-strong", "--trials contradicts"),
        ("ladder", "table-strong", "is of a table, not of a ladder"),
        ("ladder --rungs fog", "ladder-strong-m0", "--rungs contradicts"),
        ("ladder --strategy mi-mode", "ladder-strong-m0", "which says de-mean: leave it out"),
        ("ablation --factorial", "ablation-paper", "--factorial contradicts"),
        ("ablation --model strong/m0", "ablation-paper", "which says paper/m0: leave it out"),
        ("ablation --laps 1", "ablation-paper", "which says 4: leave it out"),
        ("ablation --validation-tracks 9", "ablation-paper", "--validation-tracks contradicts"),
    ],
)
def test_an_option_that_contradicts_the_folder_is_refused(
    command: str, name: str, said: str, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(RESULTS / name, out)
    before = contents(out)
    assert report(command, out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert contents(out) == before


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "experiment.json cannot be read"),
        ("[]", "experiment.json is damaged"),
        ('{"name": "table"}', "experiment.json is damaged"),
        ('{"name": "table", "rows": 3}', "experiment.json is damaged"),
    ],
)
def test_a_folder_that_tells_no_experiment_is_refused(
    text: str, said: str, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(RESULTS / "table-strong", out)
    (out / "experiment.json").write_text(text)
    assert report("table", out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


@pytest.mark.parametrize("command", ["ladder --tracks 6", "ladder --report-only"])
def test_rows_of_other_trials_are_told(
    command: str, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(RESULTS / "ladder-strong-m0", out)
    request = json.loads((out / "experiment.json").read_text())
    request["models"] = {name: today(name) for name in request["models"]}
    (out / "experiment.json").write_text(json.dumps(request))
    rows = out / "trials.csv"
    rows.write_text(rows.read_text().replace("wind", "zefiro"))
    before = contents(out)
    assert main([*command.split(), "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is damaged: experiment.json asks for no trial strong.m0-de-mean-zefiro-1000-0" in line
    assert contents(out) == before


@pytest.mark.parametrize("name", ["results.md", "results.json", "pictures/survival.png"])
def test_a_folder_in_the_way_is_told(
    name: str, out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(RESULTS / "table-strong", out)
    (out / name).mkdir(parents=True)
    assert report("table", out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(f"{out / name} cannot be written: Is a directory")


def test_a_file_in_the_way_is_told(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(RESULTS / "table-strong", out)
    (out / "pictures").write_text("mine")
    assert report("table", out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith(f"{out / 'pictures'} cannot be written: File exists")


def test_a_damaged_trace_is_told(out: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(RESULTS / "table-strong", out)
    (out / "traces").mkdir()
    (out / "traces" / "m0-mean-level1-1000-0.npz").write_bytes(b"PK half of it")
    assert report("table", out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "m0-mean-level1-1000-0.npz is damaged: remove it" in line


def test_a_calibration_that_is_not_whole_is_told(
    out: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(RESULTS / "ablation-paper", out)
    rows = out / "calibration" / "trials.csv"
    kept = [line for line in rows.read_text().splitlines(keepends=True) if "slow:0.50" not in line]
    rows.write_text("".join(kept))
    assert report("ablation", out) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "tells the pace of all/mean/slow:0.50" in line
