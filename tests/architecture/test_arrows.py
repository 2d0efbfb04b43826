"""Which room may import which, and what a command loads before it has work."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

HEAVY = ("torch", "pybullet", "cv2", "scipy", "pymavlink", "matplotlib", "pyarrow", "jaxtyping")
COMMANDS = (
    *("sitl", "flightstack.companion", "flightstack.launch"),
    *("flightstack.training", "flightstack.evaluation", "flightstack.logs", "flightstack.cli"),
    "flightstack.calibration",
)
REPORT_LOADED = """
import runpy, sys
module, *heavy = sys.argv[1:]
sys.argv = [module, "--help"]
try:
    runpy.run_module(module, run_name="__main__", alter_sys=True)
except SystemExit as end:
    assert not end.code, end.code
print("LOADED", *(name for name in heavy if name in sys.modules))
"""


def test_rooms_import_only_what_the_design_allows() -> None:
    lint_imports = Path(sys.executable).with_name("lint-imports")
    check = subprocess.run(
        [lint_imports, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert check.returncode == 0, check.stdout


@pytest.mark.parametrize("module", COMMANDS)
def test_help_loads_nothing_heavy(module: str) -> None:
    command = [sys.executable, "-c", REPORT_LOADED, module, *HEAVY]
    helped = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert helped.returncode == 0, helped.stderr
    assert "usage:" in helped.stdout
    assert helped.stdout.splitlines()[-1] == "LOADED"
