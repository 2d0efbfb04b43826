"""A vehicle's own log has the face of any log: filters, conditions, lines, exports."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from flightstack.logs import LogFileError, read, read_windows
from flightstack.logs.cli import main
from flightstack.logs.columns.expression import holds, series
from flightstack.logs.errors import UnknownNameError
from tests.unit.flightstack.logs.made_onboard import ardupilot_log, px4_log

Capture = pytest.CaptureFixture[str]


@pytest.fixture(params=["vehicle.ulg", "vehicle.bin"])
def path(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    made: Path = tmp_path / request.param
    made.write_bytes(px4_log() if made.suffix == ".ulg" else ardupilot_log())
    return made


def test_records_stand_in_order_of_time(path: Path) -> None:
    log = read(path)
    assert (np.diff(log.time_us) >= 0).all()
    assert sum(log.counts.values()) == len(log)
    for name in log.counts:
        table = log[name]
        assert np.array_equal(log.time_us[table.row], table.time_us)


def test_a_part_holds_what_falls_into_it(path: Path) -> None:
    log = read(path)
    start_us = int(log.time_us[0]) + 10_000_000
    part = log.select(start_us=start_us, end_us=start_us + 5_000_000)
    attitude = log["ATTITUDE"]
    inside = (attitude.time_us >= start_us) & (attitude.time_us < start_us + 5_000_000)
    assert part["ATTITUDE"].data.tobytes() == attitude.data[inside].tobytes()
    assert (np.diff(part["ATTITUDE"].row) > 0).all()
    assert len(part.whole) == len(log)


def test_messages_stand_among_the_records_when_asked_for(path: Path) -> None:
    log = read(path, types=["ATTITUDE"])
    assert list(log.counts) == ["ATTITUDE"]
    assert log["ATTITUDE"].data.tobytes() == read(path)["ATTITUDE"].data.tobytes()
    first, second = log.rows(slice(0, 100)), log.rows(slice(100, None))
    parts = first["ATTITUDE"].data.tobytes() + second["ATTITUDE"].data.tobytes()
    assert parts == log["ATTITUDE"].data.tobytes()


def test_chunks_of_one_time_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "texts.ulg"
    path.write_bytes(px4_log(texts=[(5_000_000, "6", "a" * 50 + "b" * 50)]))
    texts = read(path, types=["STATUSTEXT"])
    assert texts["STATUSTEXT"]["text"].tolist() == ["a" * 50, "b" * 50]


def test_conditions_reach_across_topics_and_messages(path: Path) -> None:
    log = read(path)
    rows = log["ATTITUDE"].row
    assert np.array_equal(holds("ATTITUDE.roll > 0.1", log, rows), log["ATTITUDE"]["roll"] > 0.1)
    times, values, unit = series("ATTITUDE.roll", log)
    assert (np.array_equal(times, log["ATTITUDE"].time_us), unit) == (True, "rad")
    assert np.array_equal(values, log["ATTITUDE"]["roll"].astype(np.float64))


def test_a_message_that_nothing_makes_is_empty(path: Path) -> None:
    log = read(path)
    assert len(log["CAMERA_TRIGGER"]) == 0
    assert "CAMERA_TRIGGER" not in log
    assert "ATTITUDE" in log
    assert log.select(types=["CAMERA_TRIGGER"]).counts == {}


def test_a_wrong_name_meets_the_nearest(path: Path) -> None:
    with pytest.raises(UnknownNameError, match="did you mean ATTITUDE"):
        read(path, types=["ATITUDE"])


def test_windows_are_refused(path: Path) -> None:
    with pytest.raises(LogFileError, match=r"flightstack\.logs\.read"):
        next(read_windows(path))


def test_dump_prints_topics_and_messages(path: Path, capsys: Capture) -> None:
    arguments = ["--types", "ATTITUDE", "--condition", "ATTITUDE.pitch < -0.1", "--format", "json"]
    assert main(["dump", str(path), *arguments]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {line["meta"]["type"] for line in lines} == {"ATTITUDE"}
    assert len(lines) == np.count_nonzero(read(path)["ATTITUDE"]["pitch"] < -0.1)


def test_dump_writes_no_tlog(path: Path, tmp_path: Path, capsys: Capture) -> None:
    output = tmp_path / "out.tlog"
    assert main(["dump", str(path), "-o", str(output)]) == 2
    assert "no MAVLink packets" in capsys.readouterr().err
    assert not output.exists()


def test_export_writes_every_topic(path: Path, tmp_path: Path) -> None:
    output = tmp_path / "out"
    assert main(["export", str(path), "--format", "csv", "-o", str(output)]) == 0
    log = read(path)
    assert {file.stem for file in output.iterdir()} == set(log.counts)
    name = "XKF1" if path.suffix == ".bin" else "vehicle_local_position"
    field = "VN" if path.suffix == ".bin" else "vx"
    rows = list(csv.DictReader((output / f"{name}.csv").read_text().splitlines()))
    told = [float(row[field]) for row in rows]
    assert told == pytest.approx(log[name][field].tolist(), rel=1e-6)


def test_every_command_takes_it(path: Path, tmp_path: Path, capsys: Capture) -> None:
    plot = ["plot", str(path), "ATTITUDE.roll", "-o", str(tmp_path / "roll.svg")]
    commands = [["summary"], ["messages"], ["texts"], ["params"], ["check"], ["report"], ["why"]]
    for command in [*([*c, str(path)] for c in commands), plot, ["compare", str(path), str(path)]]:
        assert main(command) == 0, command
    assert "30.0 s in the air" in capsys.readouterr().out
