"""Following a log that grows, or a live link."""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from flightstack.logs import read_bytes
from flightstack.logs.cli import main
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.following import GrowingFile, PieceReader, Watch, connection_string
from tests.unit.flightstack.logs.made_flights import make_flight


def test_pieces_of_any_size_give_every_frame_once() -> None:
    data = make_flight(3.0)
    expected = read_bytes(data)
    rng = np.random.default_rng(1)
    reader, found, at = PieceReader(), [], 0
    while at < len(data):
        size = int(rng.integers(1, 3000))
        log = reader.feed(data[at : at + size])
        found += list(zip(log.time_us.tolist(), log.frames.sequence.tolist(), strict=True))
        at += size
    sequence = expected.frames.sequence.tolist()
    assert found == list(zip(expected.time_us.tolist(), sequence, strict=True))


def test_events_are_told_once_and_in_order() -> None:
    watch = Watch()
    whole = make_flight(6.0)
    reader = PieceReader()
    events = [
        event
        for at in range(0, len(whole), 999)
        for event in watch.events(reader.feed(whole[at : at + 999]))
    ]
    told = [(event["event"], event["text"]) for event in events if event["event"] != "text"]
    assert told == [
        ("mode", "AUTO.LOITER"),
        ("mode", "AUTO.TAKEOFF"),
        ("armed", ""),
        ("mode", "OFFBOARD"),
        ("gate", "gate 0 reached"),
        ("mode", "AUTO.LAND"),
        ("disarmed", ""),
    ]
    assert sum(event["event"] == "text" for event in events) == 3
    assert watch.rates(1.0)["sources"]["1/1"]["loss_percent"] == 0.0


def test_a_growing_file_is_read_from_where_it_was(tmp_path: Path) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(b"before")
    grow = GrowingFile(path, from_start=False)
    assert grow() == b""
    with path.open("ab") as file:
        file.write(b"after")
    assert grow() == b"after"
    path.write_bytes(b"new")
    assert grow() == b"new"
    with pytest.raises(LogFileError, match="cannot be followed"):
        GrowingFile(tmp_path / "none", from_start=True)


def test_follow_reads_a_log_from_its_start(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(make_flight(3.0))
    arguments = ["follow", str(path), "--from-start", "--seconds", "0.2", "--json"]
    assert main([*arguments, "--types", "HEARTBEAT"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert any(line.get("text") == "OFFBOARD" for line in lines)
    assert sum(line.get("meta", {}).get("type") == "HEARTBEAT" for line in lines) > 10


def test_follow_listens_to_a_live_link() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    link = f"udpin:127.0.0.1:{port}"
    command = [sys.executable, "-m", "flightstack.logs", "follow", link, "--json", "--seconds", "6"]
    log = read_bytes(make_flight(3.0))
    data = log.source.read(0, log.source.size).tobytes()
    frames = zip(log.frames.offset.tolist(), log.frames.end.tolist(), strict=True)
    datagrams = [data[start:end] for start, end in frames]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ) as running:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            deadline = time.monotonic() + 5.0
            position = 0
            while time.monotonic() < deadline and running.poll() is None:
                for datagram in datagrams[position : position + 40]:
                    sender.sendto(datagram, ("127.0.0.1", port))
                position = (position + 40) % len(datagrams)
                time.sleep(0.02)
        said, _ = running.communicate(timeout=30)
    events = [json.loads(line) for line in said.splitlines()]
    assert any(event["event"] == "mode" for event in events)
    assert any(event["event"] == "rates" and event["rate_hz"] > 100 for event in events)


@pytest.mark.parametrize(
    ("text", "theirs"),
    [
        ("14550", "udpin:0.0.0.0:14550"),
        ("udpin://127.0.0.1:14540", "udpin:127.0.0.1:14540"),
        ("tcp:127.0.0.1:5760", "tcp:127.0.0.1:5760"),
    ],
)
def test_connections_are_written_as_users_write_them(text: str, theirs: str) -> None:
    assert connection_string(text) == theirs


def test_a_link_that_cannot_be_opened_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["follow", "udpin:nowhere", "--seconds", "1"]) == 2
    assert "cannot be opened" in capsys.readouterr().err
