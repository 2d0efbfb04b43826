"""The command line, as a user meets it: output, exit codes, and one line for every mistake."""

import csv
import json
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from flightstack.logs import read
from flightstack.logs.cli import main
from tests.paths import GOLDEN
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import pymavlink_messages

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "flight.tlog"
    path.write_bytes(make_flight(6.0))
    return path


def mavlogdump_line(message: object) -> str:
    """Return the line that mavlogdump prints for a message."""
    stamp = message._timestamp  # type: ignore[attr-defined]
    local = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(stamp))
    return f"{local}.{int(stamp * 100.0) % 100:02d}: {message}"


def test_a_bare_path_gives_the_summary(log: Path, capsys: Capture) -> None:
    assert main([str(log)]) == 0
    assert "mode OFFBOARD" in capsys.readouterr().out


def test_a_folder_gives_one_json_line_a_log(log: Path, capsys: Capture) -> None:
    (log.parent / "deep").mkdir()
    (log.parent / "deep" / "other.tlog").write_bytes(make_flight(3.0))
    (log.parent / "broken.tlog").write_bytes(b"not a log at all")
    assert main(["summary", str(log.parent), "--json"]) == 2
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [Path(line["log"]).name for line in lines] == [
        "broken.tlog",
        "other.tlog",
        "flight.tlog",
    ]
    assert "error" in lines[0]
    assert lines[2]["course"]["ended"] == "missed"


@pytest.mark.parametrize("types", [None, "ATTITUDE", "STATUSTEXT,HEART*", "DEBUG_FLOAT_ARRAY"])
def test_dump_prints_the_lines_of_mavlogdump(log: Path, types: str | None, capsys: Capture) -> None:
    assert main(["dump", str(log), *(["--types", types] if types else [])]) == 0
    ours = capsys.readouterr().out.splitlines()
    wanted = None if types is None else set(read(log).select(types=types.split(",")).counts)
    theirs = [
        mavlogdump_line(m) for m in pymavlink_messages(log) if not wanted or m.get_type() in wanted
    ]
    assert ours == theirs


def test_dump_takes_conditions_sources_times_and_rates(log: Path, capsys: Capture) -> None:
    main(["dump", str(log), "--types", "ATTITUDE", "--condition", "ATTITUDE.yaw > 0.5"])
    table = read(log)["ATTITUDE"]
    assert len(capsys.readouterr().out.splitlines()) == int((table["yaw"] > 0.5).sum())
    main(["dump", str(log), "--source-component", "191", "--show-source", "--show-seq"])
    lines = capsys.readouterr().out.splitlines()
    assert all("srcSystem=1 srcComponent=191 seq=" in line for line in lines)
    main(["dump", str(log), "--types", "ATTITUDE", "--from", "1", "--to", "2"])
    assert len(capsys.readouterr().out.splitlines()) == 50
    main(["dump", str(log), "--types", "ATTITUDE", "--reduce-rate", "10"])
    assert len(capsys.readouterr().out.splitlines()) == pytest.approx(len(table) / 5, abs=2)


def test_dump_writes_json_and_csv(log: Path, capsys: Capture) -> None:
    main(["dump", str(log), "--types", "STATUSTEXT", "--json"])
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert lines[0]["meta"]["type"] == "STATUSTEXT"
    assert lines[0]["data"]["text"] == "Armed by external command\t"
    main(["dump", str(log), "--types", "ATTITUDE,HEARTBEAT", "--format", "csv"])
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert len(rows) == len(read(log)["ATTITUDE"]) + len(read(log)["HEARTBEAT"])
    assert sum(row["ATTITUDE.roll"] != "" for row in rows) == len(read(log)["ATTITUDE"])


def test_dump_writes_a_tlog_that_reads_the_same(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "part.tlog"
    main(["dump", str(log), "--types", "ATTITUDE", "-o", str(out)])
    one, other = read(log)["ATTITUDE"], read(out)["ATTITUDE"]
    assert other.time_us.tolist() == one.time_us.tolist()
    assert np.array_equal(other.data, one.data)


def test_messages_texts_params_and_check(log: Path, capsys: Capture) -> None:
    assert main(["messages", str(log), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)["messages"]
    attitude = next(each for each in facts if each["type"] == "ATTITUDE")
    assert attitude["rate_hz"] == pytest.approx(50.0)
    assert main(["texts", str(log)]) == 0
    assert "Missed gate 2" in capsys.readouterr().out
    assert main(["params", str(log)]) == 0
    assert "told no parameters" in capsys.readouterr().out
    assert main(["check", str(log)]) == 0
    assert main(["check", str(log), "--strict"]) == 1
    assert "ERROR  course" in capsys.readouterr().out


def test_compare_lays_two_logs_side_by_side(log: Path, capsys: Capture) -> None:
    assert main(["compare", str(log), str(GOLDEN), "--json"]) == 0
    facts = {row["name"]: row for row in json.loads(capsys.readouterr().out)["facts"]}
    assert facts["course.gates_passed"]["difference"] == -1
    assert main(["compare", str(log), str(GOLDEN)]) == 0
    assert "offboard.rate_hz" in capsys.readouterr().out


def test_why_tells_the_moments_before_a_miss(log: Path, capsys: Capture) -> None:
    images = log.with_suffix(".frames")
    images.mkdir()
    assert main(["why", str(log), "--json"]) == 0
    moments = json.loads(capsys.readouterr().out)["moments"]
    assert len(moments) == 8
    stamp_us = moments[-1]["stamp_us"]
    (images / f"{stamp_us:012d}.png").write_bytes(b"png")
    assert main(["why", str(log), "--json"]) == 0
    last = json.loads(capsys.readouterr().out)["moments"][-1]
    assert Path(last["frame"]).name == f"{stamp_us:012d}.png"
    assert len(last["predictions"]) == 5
    assert last["before_s"] < 0.2
    assert main(["why", str(log)]) == 0
    assert "member 4" in capsys.readouterr().out


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_plots_are_drawn(log: Path, tmp_path: Path, ending: str, capsys: Capture) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / f"plot.{ending}"
    assert main(["plot", str(log), "ATTITUDE.yaw", "LOCAL_POSITION_NED.vx", "-o", str(out)]) == 0
    head = out.read_bytes()[:200]
    assert head.startswith(b"\x89PNG") if ending == "png" else b"<?xml" in head
    assert str(out) in capsys.readouterr().out


def test_help_is_instant_and_needs_no_numpy() -> None:
    code = (
        "import sys; from flightstack.logs.cli import build_parser; build_parser().format_help();"
        "print([m for m in ('numpy', 'pymavlink', 'matplotlib', 'plotly') if m in sys.modules])"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "[]"


def test_a_reader_that_stops_early_is_no_error(log: Path) -> None:
    command = f"{sys.executable} -m flightstack.logs dump {log} | head -1"
    ran = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)  # noqa: S602
    assert ran.returncode == 0
    assert ran.stderr == ""


@pytest.mark.parametrize(
    ("options", "code"),
    [(["--types", "ATTITUDE"], 0), (["--types", "ATITUDE"], 2), (["--types", "X", "--json"], 2)],
)
def test_a_dump_says_all_of_it_before_it_ends(
    options: list[str], code: int, log: Path, capsys: Capture
) -> None:
    arguments = ["dump", str(log), *options]
    assert main(arguments) == code
    expected = capsys.readouterr()
    command = [sys.executable, "-m", "flightstack.logs", *arguments]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ran.returncode == code
    assert (ran.stdout, ran.stderr) == (expected.out, expected.err)
    assert ran.stdout or ran.stderr


def test_a_dump_nobody_reads_is_no_error(log: Path) -> None:
    command = [sys.executable, "-m", "flightstack.logs", "dump", str(log), "--types", "HEARTBEAT"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        running.stdout.close()
        _, said = running.communicate(timeout=60)
    assert running.returncode == 0
    assert said == b""


MISTAKES = [
    (["summary", "{folder}/none.tlog"], "no such file"),
    (["summary", "{folder}/empty"], "holds no logs"),
    (["messages", "{folder}/empty"], "is a folder"),
    (["summary", "{folder}/flight.ulg"], "PX4 ULog"),
    (["summary", "{folder}/flight.bin"], "ArduPilot .bin"),
    (["summary", "{folder}/zero.tlog"], "is empty"),
    (["summary", "{folder}/words.txt"], "no MAVLink packet"),
    (["dump", "{log}", "--types", "ATITUDE"], "did you mean ATTITUDE"),
    (["dump", "{log}", "--condition", "ATTITUDE.roll >"], "does not parse"),
    (["dump", "{log}", "--condition", "ATTITUDE.rol > 1"], "did you mean"),
    (["dump", "{log}", "--format", "csv"], "name the messages with --types"),
    (["plot", "{log}", "ATTITUDE.rol"], "did you mean"),
    (["plot", "{log}", "GPS_RAW_INT.eph"], "holds no GPS_RAW_INT"),
    (["plot", "{log}", "ATTITUDE.roll", "-o", "{folder}/x.doc"], "ends in .png"),
    (["params", "{log}", "MPC_*"], "holds no parameter"),
    (["export", "{log}"], "say --format"),
    (["export", "{log}", "--format", "csv", "-o", "{log}/x"], "cannot be written"),
    (["report", "{log}", "-o", "{folder}/none/x.html"], "cannot be written"),
    (["report", "{log}", "--frames", "{folder}/none"], "no such folder"),
    (["compare", "{log}", "{folder}/none.tlog"], "no such file"),
    (["check", "{log}", "--checks", "{folder}/none.py"], "no such Python file"),
]


@pytest.mark.parametrize(("arguments", "reason"), MISTAKES)
def test_mistakes_get_one_line_that_says_what_to_do(
    log: Path, arguments: list[str], reason: str, capsys: Capture
) -> None:
    folder = log.parent
    (folder / "empty").mkdir()
    (folder / "flight.ulg").write_bytes(b"ULog\x01\x12\x35" + bytes(100))
    (folder / "flight.bin").write_bytes(b"\xa3\x95\x80" + bytes(100))
    (folder / "zero.tlog").write_bytes(b"")
    (folder / "words.txt").write_text("so it goes\n" * 100)
    code = main([each.format(folder=folder, log=log) for each in arguments])
    error = capsys.readouterr().err
    assert code == 2
    assert reason in error
    assert error.count("\n") == 1
    assert error.startswith("python -m flightstack.logs: ")


def test_json_errors_are_json_too(tmp_path: Path, capsys: Capture) -> None:
    assert main(["messages", str(tmp_path / "none.tlog"), "--json"]) == 2
    assert "no such file" in json.loads(capsys.readouterr().out)["error"]


def test_damage_is_told_and_located(log: Path, capsys: Capture) -> None:
    data = log.read_bytes()
    log.write_bytes(data[:5000] + b"\x00" * 50 + data[5000:] + struct.pack(">Q", 1))
    assert main(["summary", str(log), "--json"]) == 0
    damage = json.loads(capsys.readouterr().out)["damage"]
    assert damage["cut"]
    assert len(damage["regions"]) == 2
    assert abs(damage["regions"][0]["offset"] - 5000) < 100
