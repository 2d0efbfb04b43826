"""Folders of logs: on all cores, in order, and one that fails does not stop the others."""

import json
import os
from pathlib import Path

import pytest

from flightstack.logs.checks import registry
from flightstack.logs.cli import main
from flightstack.logs.errors import LogFileError
from flightstack.logs.given.many_logs import FEW, for_each
from flightstack.logs.progress import progress
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_onboard import ardupilot_log, px4_log

Capture = pytest.CaptureFixture[str]
OWN_CHECK = """
from flightstack.logs.checks import Level, check


@check("of_mine", title="Mine", meaning="Mine.")
def of_mine(flight):
    return Level.WARNING, flight.log.name
"""


def process_of(path: Path) -> tuple[str, int]:
    if path.name == "bad":
        raise LogFileError(f"{path} is bad")
    return path.name, os.getpid()


def test_logs_are_answered_in_order_by_other_processes() -> None:
    names = [f"{number}" for number in range(40)]
    names[7] = "bad"
    answers = list(for_each(process_of, [Path(name) for name in names], None))
    assert isinstance(answers[7], LogFileError)
    given = [answer for answer in answers if not isinstance(answer, LogFileError)]
    assert [name for name, _ in given] == [name for name in names if name != "bad"]
    assert os.getpid() not in {pid for _, pid in given} or (os.cpu_count() or 1) < 2


def test_few_logs_are_answered_here() -> None:
    answers = for_each(process_of, [Path("one")] * (FEW - 1), None)
    assert all(answer == ("one", os.getpid()) for answer in answers)


def test_a_folder_of_all_kinds_is_summarised(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "REGISTERED", dict(registry.REGISTERED))
    for number in range(FEW):
        (tmp_path / f"{number}.tlog").write_bytes(make_flight(1.0))
    (tmp_path / "a.ulg").write_bytes(px4_log())
    (tmp_path / "b.bin").write_bytes(ardupilot_log())
    (tmp_path / "c.ulg").write_bytes(b"not a log at all")
    checks = tmp_path / "mine.py"
    checks.write_text(OWN_CHECK)
    assert main(["summary", str(tmp_path), "--json", "--checks", str(checks)]) == 2
    out = capsys.readouterr()
    rows = [json.loads(line) for line in out.out.splitlines()]
    names = [Path(row["log"]).name for row in rows]
    assert names == [*(f"{number}.tlog" for number in range(FEW)), "a.ulg", "b.bin", "c.ulg"]
    assert "error" in rows[-1]
    mine = [check for check in rows[8]["checks"] if check["name"] == "of_mine"]
    assert mine[0]["reason"].endswith("a.ulg")
    assert "c.ulg" in out.err


def test_where_no_terminal_is_nothing_is_drawn(capsys: Capture) -> None:
    with progress("log", 10) as done:
        done(5)
    assert capsys.readouterr() == ("", "")


def test_a_terminal_sees_how_far_it_is(monkeypatch: pytest.MonkeyPatch, capsys: Capture) -> None:
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with progress("long.tlog", 10) as done:
        done(10)
    assert "long.tlog" in capsys.readouterr().err
