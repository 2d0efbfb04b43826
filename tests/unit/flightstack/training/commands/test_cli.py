import subprocess
import sys
from pathlib import Path

import pytest
import torch

from flightstack import models
from flightstack.training.commands.cli import build_parser, main


def test_help_waits_for_no_torch() -> None:
    code = (
        "import sys; from flightstack.training.commands.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "sys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_missing_data_is_one_line_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["perception", "--data", str(tmp_path), "--out", str(tmp_path / "run")]
    assert main(command) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no dataset here" in error


def test_unknown_recipe_is_one_line_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["all", "--recipe", "cake", "--data", str(tmp_path)]) == 2
    assert "known are: paper, strong" in capsys.readouterr().err


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device")
def test_cuda_without_a_device_is_one_line_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["all", "--device", "cuda", "--data", str(tmp_path / "data")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "torch finds no CUDA device here" in error
    assert not (tmp_path / "data").exists()


def test_unknown_model_is_one_line_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["all", "--only", "m7", "--data", str(tmp_path / "data")]) == 2
    assert "unknown model 'm7': choose from m0, m1, m2, m3, m4" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_published_weights_are_written_over_only_where_they_are_named(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["calibrate", "strong/m0", "--images", "1"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "came with flightstack and stays as it is" in error
    assert "--out trained/strong/m0" in error


def test_a_calibrated_copy_lies_where_it_is_wanted(tmp_path: Path) -> None:
    out = tmp_path / "mine" / "m4"
    before = models.find("strong/m4").joinpath(models.CONFIG_FILE).read_text()
    assert main(["calibrate", "strong/m4", "--images", "4", "--out", str(out)]) == 0
    assert models.load(str(out)).config.name == "m4"
    assert (out / models.CONFIG_FILE).read_text() != before
    assert models.find("strong/m4").joinpath(models.CONFIG_FILE).read_text() == before


def test_all_that_is_trained_lies_outside_of_what_was_published() -> None:
    options = build_parser().parse_args(["all"])
    assert not any(options.out.resolve() == folder.resolve() for folder in models.PUBLISHED)


@pytest.mark.parametrize("option", ["--epochs", "--mixture"])
def test_no_number_of_times_is_refused(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["policy", "--data", "a", "--perception", "b", "--out", "c", option, "0"])
    assert "must be a whole number of 1 or more, got '0'" in capsys.readouterr().err
