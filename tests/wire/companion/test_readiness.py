"""`--check`: all is looked at, nothing is moved, and what is missing is said."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from flightstack.companion.cli import main
from flightstack.companion.readiness.parameters import RULES
from flightstack.launch.instances import API_PORT, free_instance
from flightstack.logs import read
from tests.paths import DOCS

pytestmark = pytest.mark.flight
DIFFER = {"COM_OBL_RC_ACT", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST", "MPC_XY_VEL_MAX"}  # PX4's own


@pytest.fixture
def port() -> Iterator[int]:
    with free_instance() as instance:
        command = [sys.executable, "-m", "sitl", f"--instance={instance}", "-q", "--ready-after=1"]
        with subprocess.Popen([*command, "--camera-port=0"]) as process:
            yield API_PORT + instance
            process.terminate()


Found = dict[str, dict[str, str]]


def found_by(capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, Found]:
    code = main([*options, "--check", "--json", "--timeout=20"])
    told = json.loads(capsys.readouterr().out)
    assert told["ready"] == (code == 0)
    return code, {each["what"]: each for each in told["findings"]}


def test_a_simulated_vehicle_is_ready_and_stays_where_it_is(
    port: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "check.tlog"
    code, found = found_by(capsys, f"--udp={port}", f"--log={log}")
    assert code == 0
    assert found["arming"]["found"] == "ready"
    assert 15.0 < float(found["images a second"]["found"]) < 25.0
    assert found["image"]["found"].startswith("64 x 64")
    assert "round trip" in found["clock"]["found"]
    assert {rule.name for rule in RULES} <= set(found)
    assert {name for name in DIFFER if found[name]["level"] == "look"} == DIFFER
    assert set(read(log)["COMMAND_LONG"]["command"].tolist()) == {512}  # requests of messages


def test_what_is_missing_is_said_and_all_else_is_looked_at(
    port: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nowhere = ("--model=no/such", "--camera=http://127.0.0.1:1/", f"--log={tmp_path / 'a.tlog'}")
    code, found = found_by(capsys, f"--udp={port}", *nowhere)
    assert code == 1
    assert found["model no/such"]["level"] == found["camera"]["level"] == "no"
    assert "unknown model" in found["model no/such"]["found"]
    assert "cannot be reached" in found["camera"]["found"]
    assert found["COM_OF_LOSS_T"]["found"] == "1"


def test_the_parameters_are_those_of_the_document() -> None:
    text = (DOCS / "real-vehicle.md").read_text()
    table = text[text.index("## Parameters") : text.index("## Rehearsal")]
    documented = set(re.findall(r"`([A-Z0-9_]+)`", table))
    assert {rule.name for rule in RULES} <= documented
