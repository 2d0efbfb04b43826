"""File transfer, asked as the protocol's clients ask."""

import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from sitl.mavlink.servers.files.file_server import IDLE_US, MAX_CRC_BYTES, MAX_SESSIONS, FileServer
from sitl.mavlink.servers.files.file_transfer import DATA_BYTES
from sitl.mavlink.servers.files.vehicle_files import VehicleFiles
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.refusals import Refusal, Refusals
from tests.unit.sitl.mavlink.fakes import FakeOutlet, make_request

ACK, NAK = 128, 129
TERMINATE, RESET, LIST, OPEN, READ, CRC, BURST = 1, 2, 3, 4, 5, 14, 15
WRITING = (6, 7, 8, 9, 10, 11, 12, 13)  # create, write, remove, make and remove folder, ...
FAIL, INVALID_SIZE, INVALID_SESSION, NO_SESSIONS, EOF, UNKNOWN, PROTECTED, NOT_FOUND = (
    *(1, 3, 4, 5, 6, 7, 9, 10),
)
CONTENT = bytes(range(256)) * 100
SECRET = b"not for others"


class Reply:
    def __init__(self, message: Any) -> None:
        header = struct.unpack("<HBBBBBBI", bytes(message.payload[:12]))
        self.sequence, self.session, self.opcode, self.size, self.request = header[:5]
        self.is_burst_end, self.offset = header[5], header[7]
        self.data = bytes(message.payload[12 : 12 + self.size])

    @property
    def error(self) -> int | None:
        return self.data[0] if self.opcode == NAK else None


class Client:
    """Whoever asks."""

    def __init__(self, root: Path) -> None:
        self.time_us = 0
        self.refusals = Refusals()
        self.server = FileServer(VehicleFiles(root), lambda: self.time_us, self.refusals)
        self.outlet = FakeOutlet()
        self.sequence = 65534

    def replies(
        self,
        opcode: int,
        data: bytes | str = b"",
        *,
        session: int = 0,
        size: int | None = None,
        offset: int = 0,
        repeat: bool = False,
    ) -> list[Reply]:
        if not repeat:
            self.sequence = (self.sequence + 1) & 0xFFFF
        raw = data.encode(errors="surrogateescape") if isinstance(data, str) else data
        header = struct.pack(
            "<HBBBBBBI",
            *(self.sequence, session, opcode, len(raw) if size is None else size, 0, 0, 0, offset),
        )
        message = mavlink.MAVLink_file_transfer_protocol_message(
            0, 1, 1, list((header + raw).ljust(251, b"\0")[:251])
        )
        self.server.answer(message, make_request(self.outlet, system=42, component=7))
        answers = self.outlet.take()
        assert {(a.target_system, a.target_component) for a in answers} <= {(42, 7)}
        return [Reply(answer) for answer in answers]

    def ask(self, opcode: int, data: bytes | str = b"", **options: Any) -> Reply:
        (reply,) = self.replies(opcode, data, **options)
        return reply


@pytest.fixture
def root(tmp_path: Path) -> Path:
    (tmp_path / "secret").write_bytes(SECRET)
    root = tmp_path / "vehicle"
    (root / "log").mkdir(parents=True)
    (root / "general.json").write_bytes(b"{}")
    (root / "log" / "flight.tlog").write_bytes(CONTENT)
    (root / "link").symlink_to(tmp_path / "secret")
    (root / "inner").symlink_to("general.json")
    (root / "out").symlink_to(tmp_path, target_is_directory=True)
    os.mkfifo(root / "pipe")
    return root


@pytest.fixture
def client(root: Path) -> Iterator[Client]:
    client = Client(root)
    yield client
    client.server.close()


def test_a_file_is_read_piece_by_piece(client: Client) -> None:
    opened = client.ask(OPEN, "log/flight.tlog")
    assert (opened.opcode, opened.request) == (ACK, OPEN)
    assert struct.unpack("<I", opened.data) == (len(CONTENT),)
    read = b""
    while True:
        reply = client.ask(READ, session=opened.session, size=200, offset=len(read))
        if reply.error == EOF:
            break
        assert (reply.offset, reply.session) == (len(read), opened.session)
        read += reply.data
    assert read == CONTENT
    assert client.ask(TERMINATE, session=opened.session).opcode == ACK
    assert client.ask(READ, session=opened.session, size=9).error == INVALID_SESSION
    assert client.ask(TERMINATE, session=opened.session).error == INVALID_SESSION


def test_bursts_give_it_all_with_growing_numbers(client: Client) -> None:
    session = client.ask(OPEN, "/log/flight.tlog").session
    read, bursts = b"", 0
    while True:
        replies = client.replies(BURST, session=session, size=DATA_BYTES, offset=len(read))
        if replies[0].error == EOF:
            break
        bursts += 1
        first = client.sequence + 1
        assert [r.sequence for r in replies] == [(first + n) & 0xFFFF for n in range(len(replies))]
        assert [r.is_burst_end for r in replies] == [0] * (len(replies) - 1) + [1]
        for reply in replies:
            assert reply.offset == len(read)
            read += reply.data
    assert read == CONTENT
    assert bursts > 1


def test_folders_are_listed_without_links_and_pipes(client: Client) -> None:
    for path in ("", "/", ".", "/./"):
        reply = client.ask(LIST, path)
        assert reply.data == b"Fgeneral.json\t2\0Dlog\0"
    assert client.ask(LIST, "/log").data == f"Fflight.tlog\t{len(CONTENT)}\0".encode()
    assert client.ask(LIST, "/", offset=1).data == b"Dlog\0"
    assert client.ask(LIST, "/", offset=2).error == EOF
    assert client.ask(LIST, "/general.json").error == NOT_FOUND


def test_long_folders_come_in_several_answers(client: Client, root: Path) -> None:
    names = {f"{number:02d}-{'x' * 40}" for number in range(20)} | {"y" * 250}
    for name in names:
        (root / "log" / name).touch()
    listed: list[bytes] = []
    while True:
        reply = client.ask(LIST, "log", offset=len(listed))
        if reply.error == EOF:
            break
        listed += reply.data.split(b"\0")[:-1]
    assert len(listed) == len(names) + 1
    assert listed[-1] == b"S"  # a name that fits into no message is counted only


@pytest.mark.parametrize("content", [b"", b"123456789", CONTENT])
def test_checksums_are_those_of_the_protocol(client: Client, root: Path, content: bytes) -> None:
    (root / "file").write_bytes(content)
    state = 0
    for byte in content:  # as the protocol defines it: no inversion at start or end
        state = (zlib.crc32(bytes([byte]), state ^ 0xFFFFFFFF)) ^ 0xFFFFFFFF
    assert struct.unpack("<I", client.ask(CRC, "file").data) == (state,)


def test_a_huge_file_has_no_checksum(client: Client, root: Path) -> None:
    with (root / "file").open("wb") as file:
        file.truncate(MAX_CRC_BYTES + 1)
    assert client.ask(CRC, "file").error == FAIL


@pytest.mark.parametrize("opcode", [OPEN, LIST, CRC])
@pytest.mark.parametrize(
    "path",
    [
        "../secret",
        "/../secret",
        "log/../../secret",
        "link",
        "inner",
        "out",
        "out/secret",
        "a\0b/..",
    ],
)
def test_no_path_leads_out(client: Client, opcode: int, path: str) -> None:
    reply = client.ask(opcode, path)
    if "\0" in path:  # a text ends there
        assert reply.error == NOT_FOUND
    else:
        assert reply.error == PROTECTED
        assert client.refusals.totals[Refusal.FILE_ACCESS] == 1


@pytest.mark.parametrize("path", ["/etc/passwd", "//etc/passwd", "pipe", "none", "log", "", "/"])
def test_what_is_no_file_of_the_vehicle_is_not_found(client: Client, path: str) -> None:
    assert client.ask(OPEN, path).error == NOT_FOUND


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
@given(
    st.lists(
        st.sampled_from(["..", ".", "", "/", "link", "out", "secret", "log", "flight.tlog", "\\.."])
        | st.text(max_size=5),
        max_size=10,
    )
)
@example([".."] * 40)
def test_no_path_of_any_kind_gives_what_is_outside(client: Client, parts: list[str]) -> None:
    reply = client.ask(OPEN, "/".join(parts).encode(errors="surrogatepass")[:DATA_BYTES])
    if reply.opcode == ACK:
        assert client.ask(READ, session=reply.session, size=200).data[: len(SECRET)] != SECRET
        client.ask(TERMINATE, session=reply.session)


@pytest.mark.parametrize("opcode", [*WRITING, 16, 99, 255])
def test_nothing_can_be_changed(client: Client, root: Path, opcode: int) -> None:
    before = sorted(root.rglob("*"))
    assert client.ask(opcode, "general.json").error == UNKNOWN
    assert sorted(root.rglob("*")) == before
    assert (root / "general.json").read_bytes() == b"{}"


def test_sessions_are_few_and_the_forgotten_give_way(client: Client) -> None:
    opened = [client.ask(OPEN, "general.json").session for _ in range(MAX_SESSIONS)]
    assert sorted(opened) == list(range(MAX_SESSIONS))
    assert client.ask(OPEN, "general.json").error == NO_SESSIONS
    client.time_us += IDLE_US
    assert client.ask(READ, session=0, size=2).data == b"{}"  # in use
    assert client.ask(OPEN, "general.json").session == 1
    assert client.ask(RESET).opcode == ACK
    assert client.ask(READ, session=0, size=2).error == INVALID_SESSION
    assert client.ask(OPEN, "general.json").session == 0


def test_a_question_that_comes_again_gets_the_same_answer(client: Client) -> None:
    first = client.ask(OPEN, "general.json")
    again = client.ask(OPEN, "general.json", repeat=True)
    assert (again.session, again.sequence, again.data) == (
        first.session,
        first.sequence,
        first.data,
    )
    assert client.ask(OPEN, "general.json").session == first.session + 1


@pytest.mark.parametrize("opcode", [ACK, NAK])
def test_answers_of_others_are_not_answered(client: Client, opcode: int) -> None:
    assert client.replies(opcode) == []


def test_a_size_beyond_the_message_is_refused(client: Client) -> None:
    assert client.ask(OPEN, "general.json", size=DATA_BYTES + 1).error == INVALID_SIZE


def test_a_vehicle_without_a_folder_has_no_files() -> None:
    client = Client(Path())
    client.server = FileServer(VehicleFiles(None), lambda: 0)
    for opcode in (LIST, OPEN, CRC):
        assert client.ask(opcode, "@PARAM/param.pck").error == NOT_FOUND
    assert client.ask(0).opcode == ACK


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
@given(st.binary(max_size=251))
def test_no_payload_of_any_content_raises(client: Client, payload: bytes) -> None:
    message = mavlink.MAVLink_file_transfer_protocol_message(
        0, 1, 1, list(payload.ljust(251, b"\0"))
    )
    client.server.answer(message, make_request(client.outlet))
    replies = [Reply(sent) for sent in client.outlet.take()]
    assert all(reply.opcode in (ACK, NAK) for reply in replies)
    assert client.ask(RESET).opcode == ACK  # and goes on answering
