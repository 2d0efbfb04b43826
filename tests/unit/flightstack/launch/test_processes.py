"""No process outlives whoever started it."""

import sys
from pathlib import Path

import pytest

from flightstack.launch.processes import Program, running

SLEEP = [sys.executable, "-c", "import time; print('up', flush=True); time.sleep(600)"]


@pytest.mark.parametrize("ends_s", [0.0, 5.0])
def test_an_interrupted_starter_leaves_no_process(ends_s: float, tmp_path: Path) -> None:
    with (
        (tmp_path / "out").open("wb") as output,
        pytest.raises(KeyboardInterrupt),
        running(Program(command=SLEEP, stdout=output), ends_s=ends_s) as process,
    ):
        raise KeyboardInterrupt
    assert process.returncode in (-9, -15)
