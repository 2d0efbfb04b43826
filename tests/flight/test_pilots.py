"""End-to-end policies of a user's own fly: by Python, by the companion, on the tables."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

import flightstack
from flightstack.logs.columns.reading import read
from flightstack.logs.flight.decisions import find_decisions
from tests.paths import DOCS, ROOT

pytestmark = pytest.mark.flight
EXAMPLE = DOCS / "examples" / "colour"
NOTEBOOK = """
import flightstack
from colour import ColourPilot

class Halting(ColourPilot):
    def act(self, observation):
        velocities, std = super().act(observation)
        return velocities * (observation.stamp_us < 7_000_000), std

print(flightstack.fly(noise=(0.0, 0.0), fast=True, pilot=Halting).to_json())
"""


@pytest.fixture
def importable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("importable")
def test_colour_alone_finds_through_a_lap_and_says_how_sure_it_is() -> None:
    result = flightstack.fly(track_seed=7, noise=(1.0, 2.0), fast=True, pilot="colour:ColourPilot")
    assert (result.outcome, result.gates_passed) == ("completed", 8)
    assert (result.model, result.strategy) == ("colour:ColourPilot", "act")
    decisions = find_decisions(read(result.log))
    assert len(decisions) > 500
    assert decisions.aleatoric_std.min() > 0.0
    assert not decisions.epistemic_std.any()


def test_one_that_a_script_defines_flies_too(tmp_path: Path) -> None:
    path = os.pathsep.join([str(EXAMPLE), str(ROOT)])
    ran = subprocess.run(
        [sys.executable, "-c", NOTEBOOK],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    assert '"model": "Halting"' in ran.stdout
    assert '"gates_passed": 0' in ran.stdout


def test_it_is_benchmarked_without_a_model(tmp_path: Path) -> None:
    rung = tmp_path / "calm.toml"
    rung.write_text('about = "gates where they belong"\nnoise_m = [0.0, 0.0]\n')
    path = os.pathsep.join([str(EXAMPLE), str(ROOT)])
    done = subprocess.run(
        [
            *(sys.executable, "-m", "flightstack.cli", "evaluate", "benchmark"),
            *("--pilot", "colour:ColourPilot", "--against", "--rungs", str(rung)),
            *("--tracks=1", "--laps=1", "--jobs=1", "--out", str(tmp_path / "out")),
        ],
        env=os.environ | {"PYTHONPATH": path},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "trials.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["row"], row["model"]) == ("colour.colourpilot", "colour:ColourPilot")
    assert int(row["gates_passed"]) > 3  # by this light, before these grounds
    assert row["weights_sha256"] == ""
