"""End-to-end policies of a user's own fly: by Python, by the companion, on the tables."""

import csv
import json
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
LEARNED = DOCS / "examples" / "learned"
MAX_LINES = 60  # of a file of an example
GYM_POLICY = """
import numpy as np, flightstack
from flightstack.gym import as_pilot

class Straight:
    def reset(self):
        self.images = 0
    def __call__(self, observed):
        self.images += 1
        action = np.array([-0.25, 0.0, 0.0, 0.0]), np.full(4, 0.5)
        return action if observed["image"].shape == (64, 64, 3) else None

print(flightstack.fly(noise=(0.0, 0.0), fast=True, pilot=as_pilot(Straight())).to_json())
"""
NOTEBOOK = """
import flightstack
from colour import ColourPilot

class Unswerving(ColourPilot):
    def act(self, observation):
        velocities, std = super().act(observation)
        return abs(velocities), std

print(flightstack.fly(noise=(0.0, 0.0), fast=True, pilot=Unswerving).to_json())
"""


@pytest.fixture
def importable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in (EXAMPLE, LEARNED):
        monkeypatch.syspath_prepend(str(folder))
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("importable")
def test_colour_alone_finds_through_a_lap_and_says_how_sure_it_is() -> None:
    result = flightstack.fly(
        track_seed=7,
        noise=(1.0, 2.0),
        fast=True,
        pilot="colour:ColourPilot",
        log=Path("here", "lap.tlog"),
    )
    assert result.log == Path("here", "lap.tlog")
    assert (result.outcome, result.gates_passed) == ("completed", 8)
    assert (result.model, result.strategy) == ("colour:ColourPilot", "act")
    decisions = find_decisions(read(result.log))
    assert len(decisions) > 500
    assert decisions.aleatoric_std.min() > 0.0
    assert not decisions.epistemic_std.any()


def run(folder: Path, *words: str) -> str:
    """Run Python where the examples can be imported; returns what it printed."""
    path = os.pathsep.join(map(str, (EXAMPLE, LEARNED, ROOT)))
    ran = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env={"OMP_NUM_THREADS": "1"} | os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def test_one_that_a_script_defines_flies_too(tmp_path: Path) -> None:
    said = run(tmp_path, "-c", NOTEBOOK)
    assert json.loads(said)["model"] == "Unswerving"
    assert json.loads(said)["gates_passed"] < 8  # it never sinks, nor turns left


def test_a_policy_of_the_environment_flies_over_mavlink(tmp_path: Path) -> None:
    said = json.loads(run(tmp_path, "-c", GYM_POLICY))
    assert (said["model"], said["outcome"]) == ("pilot", "collision")
    decisions = find_decisions(read(tmp_path / said["log"]))
    assert decisions.command[-1] == pytest.approx([2.0, 0.0, 0.0, 0.0])
    assert decisions.aleatoric_std[-1] == pytest.approx([2.0, 1.5, 1.5, 0.5])  # half of each range


@pytest.mark.usefixtures("importable")
def test_a_small_network_learns_in_the_environment_and_flies_over_mavlink(tmp_path: Path) -> None:
    script = str(LEARNED / "train.py")
    words = ("--gates=1", "--laps=1", "--flights=2", "--noise", "0", "0")
    assert "of 8 gates" in run(tmp_path, script, *words).splitlines()[-1]
    result = flightstack.fly(
        noise=(0.0, 0.0), fast=True, pilot="learned:LearnedPilot", record_frames=True
    )
    assert result.gates_passed >= 1
    assert len(list(result.log.with_suffix(".frames").glob("*.png"))) >= result.frames


EXAMPLES = [
    each for name in ("colour", "learned") for each in (DOCS / "examples" / name).glob("*.py")
]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_examples_are_short(example: Path) -> None:
    assert len(example.read_text().splitlines()) <= MAX_LINES + 1


def test_it_is_benchmarked_without_a_model(tmp_path: Path) -> None:
    rung = tmp_path / "calm.toml"
    rung.write_text('about = "gates where they belong"\nnoise_m = [0.0, 0.0]\n')
    run(
        tmp_path,
        *("-m", "flightstack.cli", "evaluate", "benchmark", "--pilot", "colour:ColourPilot"),
        *("--against", "--rungs", str(rung), "--tracks=1", "--laps=1", "--jobs=1"),
        f"--out={tmp_path / 'out'}",
    )
    with (tmp_path / "out" / "trials.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert (row["row"], row["model"]) == ("colour.colourpilot", "colour:ColourPilot")
    assert int(row["gates_passed"]) > 3  # by this light, before these grounds
    assert row["weights_sha256"] == ""
