"""Texts of unknown origin: read whole, and never code for a terminal or a spreadsheet."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.cli import main
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.kinds.made_vehicles import Entry, Sender, Vehicle, entries, tlog
from tests.unit.flightstack.logs.made_logs import START_US

RED = b"caf\xe9 \x1b[31mred\x1b[0m \x9b1m"


def said(text: bytes, text_id: int = 0, chunk: int = 0) -> Any:
    return mavlink.MAVLink_statustext_message(4, text, text_id, chunk)


def texts_of(*messages: Any) -> list[str]:
    sender = Sender()
    rows = [(START_US + n * 1000, sender.pack(message)) for n, message in enumerate(messages)]
    return [text.text for text in Flight(read_bytes(tlog(rows))).texts]


def test_utf_8_is_read_even_across_chunks() -> None:
    text = "Grüße " + "ä" * 60 + " 🚁"
    raw = text.encode()
    chunks = [raw[start : start + 50] for start in range(0, len(raw), 50)]
    assert texts_of(*(said(chunk, 9, n) for n, chunk in enumerate(chunks))) == [text]


@pytest.mark.parametrize(
    ("chunks", "shown"),
    [
        ({0: b"A" * 50, 2: b"C"}, "A" * 50 + " [...] C"),
        ({1: b"B" * 50, 2: b"C"}, "[...] " + "B" * 50 + "C"),
        ({0: b"A" * 50}, "A" * 50 + " [...]"),
        ({0: b"A" * 50, 1: b"B"}, "A" * 50 + "B"),
    ],
)
def test_a_lost_chunk_is_shown(chunks: dict[int, bytes], shown: str) -> None:
    assert texts_of(*(said(chunk, 3, n) for n, chunk in chunks.items())) == [shown]


def hostile() -> list[Entry]:
    sender = Sender()
    names = (b"\x1b[2JP", b"=1+1", b"@SUM(A1)")
    rows = [(START_US + 5, sender.pack(said(RED))), (START_US + 6, sender.pack(said(b"a\nb")))]
    for n, name in enumerate(names):
        message = mavlink.MAVLink_param_value_message(name, n, 9, 3, n)
        rows.append((START_US + 10 + n, sender.pack(message)))
        rows.append((START_US + 20 + n, sender.pack(said(name))))
    return entries(Vehicle(end_s=5)) + rows


@pytest.mark.parametrize("command", ["summary", "texts", "params", "dump", "check", "messages"])
def test_no_control_character_reaches_the_terminal(
    command: str, tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]
) -> None:
    path = tmp_path / "evil\x1b[31m.tlog"
    path.write_bytes(tlog(hostile()))
    assert main([command, str(path)]) == 0
    out, err = capfdbinary.readouterr()
    shown = out.decode() + err.decode()
    assert out
    assert all(each.isprintable() or each == "\n" for each in shown)


def test_no_text_is_a_formula_to_a_spreadsheet(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(tlog(hostile()))

    def names(*options: str) -> list[str]:
        folder = tmp_path / f"csv{len(options)}"
        assert main(["export", str(path), "--format", "csv", "-o", str(folder), *options]) == 0
        capsys.readouterr()
        rows = csv.DictReader((folder / "PARAM_VALUE.csv").read_text().splitlines())
        return [row["param_id"] for row in rows][1:]

    assert names() == ["'=1+1", "'@SUM(A1)"]
    assert names("--raw-cells") == ["=1+1", "@SUM(A1)"]


@pytest.mark.parametrize("kind", ["mcap", "csv", "parquet"])
def test_a_log_without_sane_stamps_is_exported(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "log.raw"
    raw = [packet for _, packet in entries(Vehicle(end_s=5))]
    path.write_bytes((b"\xff" * 40).join([b"".join(raw[:20]), b"".join(raw[20:])]))
    output = tmp_path / f"out.{kind}"
    assert main(["export", str(path), "--format", kind, "-o", str(output), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["messages"] == len(raw)
