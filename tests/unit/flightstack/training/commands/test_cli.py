import subprocess
import sys
from pathlib import Path

import pytest
import torch

from flightstack.training.commands.cli import main


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
