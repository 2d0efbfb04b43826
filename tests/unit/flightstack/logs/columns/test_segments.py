"""Large logs in parts: what the parts say together is what the whole says."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from pyarrow import parquet
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import LogFileError, read, read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.cli import main
from flightstack.logs.columns import segments
from flightstack.logs.columns.segments import LogPart, read_parts
from flightstack.logs.facts.merging import merge_parts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import START_US, packet, record

FLIGHTS = 4
ENOUGH = 1200  # packets: less than a flight has, a third of it more
# medians, percentiles and lags of parts are averaged, checks judge part by part, and a gate counts
# in each part in which it was passed
AVERAGED = ("offboard", "checks", "links", "damage", "course")


def flights(count: int) -> bytes:
    """Return flights one behind the other, a minute from start to start."""
    raw = make_flight(4.0)
    log = read_bytes(raw)
    parts = []
    for number in range(count):
        for stamp, start, end in zip(
            log.packets.time_us.tolist(), log.packets.offset.tolist(), log.packets.end.tolist(),
            strict=True,
        ):  # fmt: skip
            parts.append(struct.pack(">Q", stamp + number * 40_000_000) + raw[start:end])
    return b"".join(parts)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "long.tlog"
    path.write_bytes(flights(FLIGHTS))
    return path


def facts_of(part: LogPart) -> Facts:
    flight = Flight(part.log)
    return summarise(flight, run_checks(flight))


def test_parts_hold_every_packet_once(path: Path) -> None:
    whole = read(path)
    parts = list(read_parts(path, part_packets=ENOUGH, window_bytes=8192))
    assert len(parts) == FLIGHTS
    offsets = np.concatenate([part.log.packets.offset + part.start for part in parts])
    assert np.array_equal(offsets, whole.packets.offset)
    assert all(part.log.damage.is_clean for part in parts)
    roll = np.concatenate([part.log["ATTITUDE"]["roll"] for part in parts])
    assert np.array_equal(roll, whole["ATTITUDE"]["roll"])


def test_a_part_ends_on_the_ground(path: Path) -> None:
    for part in read_parts(path, part_packets=ENOUGH, window_bytes=8192):
        assert Flight(part.log).ending == "landed and disarmed"


def test_the_summary_of_the_parts_is_that_of_the_whole(path: Path) -> None:
    flight = Flight(read(path))
    whole = summarise(flight, run_checks(flight))
    parts = merge_parts(
        (facts_of(p), p.start) for p in read_parts(path, part_packets=ENOUGH, window_bytes=8192)
    )
    assert parts.keys() == whole.keys()
    for name, value in whole.items():
        if name not in AVERAGED:
            close = pytest.approx(value, rel=1e-2) if isinstance(value, float) else value
            assert parts[name] == close, name
    for name in ("setpoints", "decisions", "entries", "duration_s"):
        assert parts["offboard"][name] == whole["offboard"][name]
    assert [link["messages"] for link in parts["links"]] == [
        link["messages"] for link in whole["links"]
    ]


def test_a_flight_that_is_torn_counts_once(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(segments, "MAX_PARTS", 1)
    monkeypatch.setattr(segments, "LEAST_REST", 100)
    raw = path.read_bytes()[: len(path.read_bytes()) // FLIGHTS]
    path.write_bytes(raw)
    count = len(read_bytes(raw))
    made = list(read_parts(path, part_packets=count // 2, window_bytes=4096))
    assert len(made) > 1
    parts = merge_parts((facts_of(part), part.start) for part in made)
    flight = Flight(read(path))
    whole = summarise(flight, run_checks(flight))
    assert parts["flights"] == whole["flights"] == 1
    assert parts["modes"] == whole["modes"]
    assert parts["flight_time_s"] == pytest.approx(whole["flight_time_s"], abs=1.1)


def test_damage_stands_where_it_is_in_the_file(path: Path) -> None:
    raw = bytearray(path.read_bytes())
    place = int(read_bytes(bytes(raw)).packets.offset[-100])
    raw[place + 12] ^= 0xFF
    path.write_bytes(raw)
    parts = merge_parts(
        (facts_of(p), p.start) for p in read_parts(path, part_packets=ENOUGH, window_bytes=8192)
    )
    assert [region["offset"] for region in parts["damage"]["regions"]] == [place - 8]


def test_commands_read_large_logs_in_parts(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = {}
    for name, size in (("whole", 1 << 30), ("parts", 1)):
        monkeypatch.setattr(segments, "LARGE_BYTES", size)
        monkeypatch.setattr(segments, "PART_PACKETS", 500)
        for command in ("summary", "messages"):
            assert main([command, str(path), "--json"]) == 0
            said[name, command] = json.loads(capsys.readouterr().out)
    assert said["whole", "summary"]["counts"] == said["parts", "summary"]["counts"]
    counts = [
        {(row["type"], row["component"]): (row["count"], row["rate_hz"])
         for row in said[name, "messages"]["messages"]}
        for name in ("whole", "parts")
    ]  # fmt: skip
    assert counts[0] == counts[1]


@pytest.mark.parametrize(
    "command",
    [
        ("texts",),
        ("texts", "--json"),
        ("params", "--json"),
        ("dump",),
        ("dump", "--json", "--types", "HEARTBEAT"),
        ("dump", "--types", "ATTITUDE,HEARTBEAT", "--format", "csv"),
        ("dump", "--from", "50", "--to", "90"),
        ("dump", "--show-types"),
        ("dump", "--types", "SYS_STATUS", "-o", "{}"),
        ("export", "--format", "csv", "-o", "{}"),
        ("export", "--format", "parquet", "-o", "{}"),
        ("export", "-o", "{}.mcap"),
    ],
    ids=" ".join,
)
def test_a_large_log_is_told_as_if_it_were_read_whole(
    path: Path,
    command: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
    capfdbinary: pytest.CaptureFixture[bytes],
) -> None:
    said = {}
    for how, size in (("whole", 1 << 30), ("parts", 1)):
        monkeypatch.setattr(segments, "LARGE_BYTES", size)
        monkeypatch.setattr(segments, "PART_PACKETS", ENOUGH)
        output = path.parent / how
        name, *options = (word.format(output) for word in command)
        assert main([name, str(path), *options]) == 0
        printed = capfdbinary.readouterr().out.replace(str(output).encode(), b"out")
        written = sorted(path.parent.glob(f"{how}*")) + sorted(output.glob("*"))
        said[how] = (printed, [content_of(file) for file in written if file.is_file()])
    assert said["parts"] == said["whole"]


def content_of(file: Path) -> object:
    """Return what a file holds, whatever the row groups or chunks that it is kept in."""
    if file.suffix == ".parquet":
        return parquet.read_table(file)
    if file.suffix == ".mcap":
        with file.open("rb") as stream:
            return [m for *_, m in make_reader(stream).iter_messages()]
    return file.read_bytes()


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "nothing.tlog"
    path.write_bytes(b"")
    with pytest.raises(LogFileError, match="empty"):
        next(read_parts(path))


def test_unknown_packets_at_the_edge_of_a_window_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "unknown.tlog"
    known = mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 1)
    sender = mavlink.MAVLink(None, 1, 1)
    raws = [
        packet(54_321, b"\x01" * 20, sequence=n, extra=7) if n % 5 == 4 else known.pack(sender)
        for n in range(120)
    ]
    path.write_bytes(b"".join(record(START_US + n * 1000, raw) for n, raw in enumerate(raws)))
    for window_bytes in range(1500, 1600):
        assert len(read(path, window_bytes=window_bytes)) == len(raws), window_bytes
