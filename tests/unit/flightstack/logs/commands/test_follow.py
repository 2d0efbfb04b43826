"""The command that follows a log that grows, or a live link."""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flightstack.logs import read_bytes
from flightstack.logs.cli import main
from tests.unit.flightstack.logs.made_flights import make_flight


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
    packets = zip(log.packets.offset.tolist(), log.packets.end.tolist(), strict=True)
    datagrams = [data[start:end] for start, end in packets]
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
