"""The log of a flight, and how it is fetched."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sitl.errors import UsageError
from sitl.mavlink.servers.files import flight_log
from sitl.mavlink.servers.files.flight_log import FlightLog
from sitl.mavlink.servers.files.log_server import MAX_BURST, LogServer
from sitl.mavlink.servers.files.storage import Storage
from sitl.mavlink.wire.crc32 import crc32
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, wrap
from sitl.mavlink.wire.refusals import Refusal, Refusals
from tests.unit.sitl.mavlink.fakes import FakeOutlet, make_request

EPOCH_US = 1_700_000_000_000_000
HEARTBEAT = wrap(
    pack(mavlink.MAVLink_heartbeat_message(2, 12, 29, 0, 3, 3)), sequence=0, system=1, component=1
)


class Clock:
    time_us = 0

    def __call__(self) -> int:
        return self.time_us


def make_log(folder: Path | None) -> tuple[FlightLog, Clock]:
    clock = Clock()
    return FlightLog(folder, unix_epoch_us=EPOCH_US, clock=clock), clock


def fly(log: FlightLog, packets: int) -> None:
    log.follow(armed=True)
    for _ in range(packets):
        log.record(HEARTBEAT, link=1)
    log.flush()
    log.follow(armed=False)


def test_a_log_lasts_from_arming_to_disarming(tmp_path: Path) -> None:
    log, clock = make_log(tmp_path)
    log.record(HEARTBEAT, link=0)
    clock.time_us = 5_000_000
    fly(log, 3)
    log.record(HEARTBEAT, link=0)
    (finished,) = log.finished
    assert finished.started_unix_s == 1_700_000_005
    assert finished.size == finished.path.stat().st_size == 3 * (8 + len(HEARTBEAT))
    fly(log, 1)
    assert len({finished.path for finished in log.finished}) == 2


def test_a_flight_under_way_is_kept_when_the_vehicle_ends(tmp_path: Path) -> None:
    log, _ = make_log(tmp_path)
    log.follow(armed=True)
    log.record(HEARTBEAT, link=0)
    log.close()
    assert log.finished[0].size > 0


def test_logs_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flight_log, "MAX_BYTES", 5 * len(HEARTBEAT))
    monkeypatch.setattr(flight_log, "MAX_FLIGHTS", 2)
    log, _ = make_log(tmp_path)
    for _ in range(4):
        fly(log, 9)
    assert [finished.size for finished in log.finished] == [5 * (8 + len(HEARTBEAT))] * 2


def test_a_folder_that_went_away_does_not_end_the_flight(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    log, _ = make_log(tmp_path / "gone")
    for _ in range(3):
        fly(log, 2)
    assert log.finished == []
    assert len(caplog.records) == 1


class Client:
    def __init__(self, folder: Path | None) -> None:
        self.log, _ = make_log(folder)
        self.refusals = Refusals()
        self.server = LogServer(self.log, self.refusals)
        self.outlet = FakeOutlet()
        self.request = make_request(self.outlet)

    def entries(self, start: int = 0, end: int = 0xFFFF) -> list[tuple[int, int, int, int]]:
        message = mavlink.MAVLink_log_request_list_message(1, 1, start, end)
        self.server.request_list(message, self.request)
        return [(m.id, m.num_logs, m.last_log_num, m.size) for m in self.outlet.take()]

    def fetch(self, number: int, offset: int = 0, count: int = 0xFFFFFFFF) -> list[Any]:
        message = mavlink.MAVLink_log_request_data_message(1, 1, number, offset, count)
        self.server.request_data(message, self.request)
        while self.server.is_sending:
            self.server.advance(4_000)
        return self.outlet.take()


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    client = Client(tmp_path)
    yield client
    client.server.close()


def test_without_a_flight_there_are_no_logs(client: Client) -> None:
    assert client.entries() == [(0, 0, 0, 0)]
    assert client.fetch(0) == []


def test_logs_are_listed_as_far_as_asked(client: Client) -> None:
    for packets in (1, 2, 3):
        fly(client.log, packets)
    size = 8 + len(HEARTBEAT)
    assert client.entries() == [(n, 3, 2, (n + 1) * size) for n in range(3)]
    assert client.entries(1, 1) == [(1, 3, 2, 2 * size)]
    assert client.entries(7, 9) == [(2, 3, 2, 3 * size)]
    assert client.entries(2, 1) == []


@pytest.mark.parametrize(("offset", "count"), [(0, 2**32 - 1), (90, 180), (1000, 91), (5, 7)])
def test_a_log_comes_in_pieces(client: Client, offset: int, count: int) -> None:
    fly(client.log, 200)
    content = client.log.finished[0].path.read_bytes()
    pieces = client.fetch(0, offset, count)
    assert b"".join(bytes(p.data[: p.count]) for p in pieces) == content[offset:][:count]
    assert [p.ofs for p in pieces] == [offset + 90 * n for n in range(len(pieces))]
    assert {p.id for p in pieces} == {0}


def test_beyond_its_end_a_log_is_empty(client: Client) -> None:
    fly(client.log, 1)
    assert [p.count for p in client.fetch(0, 10**6, 90)] == [0]


def test_a_transfer_is_paced_and_can_be_ended(client: Client) -> None:
    fly(client.log, 2000)
    message = mavlink.MAVLink_log_request_data_message(1, 1, 0, 0, 0xFFFFFFFF)
    client.server.request_data(message, client.request)
    client.server.advance(10**9)
    assert len(client.outlet.take()) == MAX_BURST
    client.server.request_end(None, client.request)
    assert not client.server.is_sending
    client.server.request_data(message, client.request)
    client.server.request_data(message, client.request)  # begins anew
    assert len(client.server._transfers) == 1


def test_erasing_is_refused(client: Client) -> None:
    fly(client.log, 1)
    client.server.erase(mavlink.MAVLink_log_erase_message(1, 1), client.request)
    assert client.log.finished[0].path.exists()
    assert client.refusals.totals == {Refusal.FILE_ACCESS: 1}
    client.log.finished[0].path.unlink()
    assert client.fetch(0) == []


def test_metadata_lead_from_the_message_to_the_parameters(tmp_path: Path) -> None:
    described = [{"name": "MAV_SYS_ID", "type": "Int32", "default": 1, "min": 1, "max": 250}]
    storage = Storage(tmp_path / "new" / "folder", parameters=described)
    assert storage.metadata is not None
    message = storage.metadata.message(2_000_000)
    assert (message.time_boot_ms, message.uri) == (2000, b"mftp:///general.json")
    general = (tmp_path / "new" / "folder" / "general.json").read_bytes()
    assert message.file_crc == crc32(general)
    parameters = (tmp_path / "new" / "folder" / "parameters.json").read_bytes()
    assert str(crc32(parameters)).encode() in general
    assert b"mftp:///parameters.json" in general
    storage.close()


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match=r"--files .*file.x"):
        Storage(tmp_path / "file" / "x")
