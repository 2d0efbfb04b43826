"""What flies is light: neither torch nor pybullet is loaded, or even there."""

import os
import subprocess
import sys
from pathlib import Path

from tests.paths import ROOT

SILENCING = ("CI", "ORT_DISABLE_TELEMETRY", "ORT_RUNNING_UNIT_TESTS")  # what else keeps it from it
FLIES = """
import sys
sys.modules["torch"] = sys.modules["pybullet"] = None
import numpy as np
import flightstack.companion.flight, flightstack.companion.loop, flightstack.companion.belief_pilot
import flightstack.companion.piloting.worker, flightstack.logs.cli
from flightstack.companion.pipeline import load_pipeline
from flightstack.gate_models import load_gate_model
from flightstack.records import Image
image = Image(stamp_us=0, sequence=0, rgb=np.zeros((64, 64, 3), np.uint8))
print(load_pipeline("strong/m0").decide(image).command.shape)
print(load_gate_model("strong/b0").detector.detect(image.rgb).score.ndim)
"""


def test_nothing_reports_how_it_is_used(tmp_path: Path) -> None:
    """ONNX Runtime would: it leaves a file of the session with whom it has begun to report."""
    command = [sys.executable, "-c", FLIES]
    telling = {key: value for key, value in os.environ.items() if key not in SILENCING}
    environment = {**telling, "TMPDIR": str(tmp_path)}
    subprocess.run(command, check=True, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL)
    assert list(tmp_path.iterdir()) == []


def test_a_pipeline_decides_where_torch_and_pybullet_cannot_be_imported() -> None:
    command = [sys.executable, "-c", FLIES]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.stderr == ""
    assert done.stdout.split("\n") == ["(4,)", "1", ""]
