"""Reading a log that grows, or a live link."""

from pathlib import Path

import numpy as np
import pytest

from flightstack.logs import read_bytes
from flightstack.logs.cli import main
from flightstack.logs.columns.live import GrowingFile, PieceReader, connection_string
from flightstack.logs.errors import LogFileError
from tests.unit.flightstack.logs.made_flights import make_flight


def test_pieces_of_any_size_give_every_packet_once() -> None:
    data = make_flight(3.0)
    expected = read_bytes(data)
    rng = np.random.default_rng(1)
    reader, found, at = PieceReader(), [], 0
    while at < len(data):
        size = int(rng.integers(1, 3000))
        log = reader.feed(data[at : at + size])
        found += list(zip(log.time_us.tolist(), log.packets.sequence.tolist(), strict=True))
        at += size
    sequence = expected.packets.sequence.tolist()
    assert found == list(zip(expected.time_us.tolist(), sequence, strict=True))


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
