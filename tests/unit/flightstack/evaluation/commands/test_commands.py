import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flightstack.evaluation.cli import COMMANDS, main
from flightstack.evaluation.offline.predicting import PARTS
from flightstack.evaluation.offline.scenes import SPOILS
from flightstack.records import VELOCITIES
from tests.pictures import pixels


def test_help_waits_for_no_torch() -> None:
    code = (
        "import sys; from flightstack.evaluation.cli import main\n"
        "try: main(['offline', '--help'])\n"
        "except SystemExit: pass\n"
        "sys.exit('torch' in sys.modules or 'sklearn' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("command", sorted(set(COMMANDS) - {"table"}))  # which takes a recipe
def test_unknown_model_is_one_line_and_exit_code_4(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--model", "strong/m9", "--out", str(tmp_path / "out")]
    yours = ["--strategy", "all/mode/same"] if command == "benchmark" else []
    assert main([command, *options, *yours]) == 4
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "unknown model 'strong/m9'" in error
    assert not (tmp_path / "out").exists()


def test_figures_draws_the_ambiguous_image(tmp_path: Path) -> None:
    assert main(["figures", "--out", str(tmp_path)]) == 0
    picture = pixels(tmp_path / "ambiguity.png")
    assert picture.shape[1] > picture.shape[0] > 500
    assert picture.std() > 20.0


def test_offline_writes_tables_json_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sizes = ["--images", "40", "--scene-images", "12"]
    assert main(["offline", *sizes, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "CRPS" in shown
    assert "AUROC" in shown
    (judged,) = json.loads((tmp_path / "offline.json").read_text())
    assert set(judged["velocities"]) == set(VELOCITIES)
    assert set(judged["auroc"]) == set(SPOILS) - {"plain"}
    areas = [judged["auroc"][kind][part] for kind in judged["auroc"] for part in PARTS]
    assert all(0.0 <= area <= 1.0 for area in areas)
    assert judged["auroc"]["no gate"]["perceptual"] > 0.8
    curve = judged["velocities"]["vx"]["calibration"]["covered"]
    assert (np.diff(curve) >= 0.0).all()
    for name in ("calibration.png", "auroc.png"):
        assert pixels(tmp_path / name).std() > 10.0
