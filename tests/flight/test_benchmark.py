"""A user's own policy flies on the tables, next to a model that comes along."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

pytestmark = pytest.mark.flight
NIGHT = """
about = "hardly anything is seen, and so the flight is short"
noise_m = [0.0, 0.0]

[conditions.light]
daylight_share = 0.05
"""


def test_a_policy_of_ones_own_flies_beside_the_model_that_it_changes(tmp_path: Path) -> None:
    rung = tmp_path / "night.toml"
    rung.write_text(NIGHT)
    out = tmp_path / "out"
    path = os.pathsep.join([str(ROOT / "docs/examples/cautious"), str(ROOT)])
    done = subprocess.run(
        [
            *(sys.executable, "-m", "flightstack.evaluation", "benchmark"),
            *("--policy", "cautious:HumblePolicy", "--strategy", "cautious:CautiousStrategy"),
            *("--rungs", str(rung), "--tracks=1", "--laps=1", "--jobs=1", "--out", str(out)),
        ],
        env=os.environ | {"PYTHONPATH": path},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    with (out / "trials.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    mine = "cautious.humblepolicy-cautious.cautiousstrategy"
    assert [row["row"] for row in rows] == [mine, "strong.m0-de-mean"]
    assert {row["condition"] for row in rows} == {"night"}
    ours, theirs = (float(row["command_vx_m_s"]) for row in rows)
    assert ours < theirs  # its strategy slows down in doubt
    assert f"Benchmark, {mine}" in (out / "results.md").read_text()
