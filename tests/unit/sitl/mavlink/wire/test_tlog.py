import resource
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from pymavlink import mavutil

from sitl.errors import UsageError
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, wrap
from sitl.mavlink.wire.tlog import TlogWriter

HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 12, 29, 0, 3, 3)
EPOCH_US = 1_700_000_000_000_000


def test_pymavlink_reads_times_and_links_back(tmp_path: Path) -> None:
    path = tmp_path / "flight.tlog"
    now_us = 0
    writer = TlogWriter(path, unix_epoch_us=EPOCH_US, clock=lambda: now_us)
    for number in range(5):
        now_us = number * 52_000
        raw = wrap(pack(HEARTBEAT), sequence=number, system=1, component=1)
        writer.record(raw, link=number % 2)
    writer.flush()
    log = mavutil.mavlink_connection(str(path), robust_parsing=True)
    messages = [log.recv_match(type="HEARTBEAT") for _ in range(5)]
    assert log.recv_match() is None
    log.close()
    writer.close()
    times_us = [round((m._timestamp - EPOCH_US / 1e6) * 1e6) for m in messages]
    assert times_us == pytest.approx([0, 52_000, 104_000, 156_000, 208_000], abs=4)
    assert [m.get_seq() for m in messages] == [0, 1, 2, 3, 4]


def test_a_long_log_goes_on_in_further_files(tmp_path: Path) -> None:
    raw = wrap(pack(HEARTBEAT), sequence=0, system=1, component=1)
    record = 8 + len(raw)
    path = tmp_path / "flight.tlog"
    writer = TlogWriter(path, unix_epoch_us=0, clock=lambda: 0, max_bytes=2 * record)
    for _ in range(5):
        writer.record(raw, link=0)
        writer.flush()
    writer.close()
    parts = [tmp_path / name for name in ("flight.tlog", "flight.1.tlog", "flight.2.tlog")]
    assert [part.stat().st_size // record for part in parts] == [2, 2, 1]


def test_a_file_that_cannot_follow_ends_the_log(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "flight.1.tlog").mkdir()
    path = tmp_path / "flight.tlog"
    writer = TlogWriter(path, unix_epoch_us=0, clock=lambda: 0, max_bytes=1)
    for _ in range(3):
        writer.record(wrap(pack(HEARTBEAT), sequence=0, system=1, component=1), link=0)
        writer.flush()
    writer.close()
    assert caplog.text.count("ends here") == 1
    assert path.stat().st_size > 0


def test_a_path_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    path = tmp_path / "no" / "such" / "folder.tlog"
    with pytest.raises(UsageError, match=r"folder\.tlog"):
        TlogWriter(path, unix_epoch_us=0, clock=lambda: 0)


@pytest.fixture
def file_limit() -> Iterator[int]:
    """A disk that is full after some bytes, as the kernel enforces it."""
    limit = 100_000
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    yield limit
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, ignored)


def test_a_full_disk_is_reported_once_and_leaves_whole_records(
    tmp_path: Path, file_limit: int, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "flight.tlog"
    writer = TlogWriter(path, unix_epoch_us=EPOCH_US, clock=lambda: 0)
    raw = wrap(pack(HEARTBEAT), sequence=0, system=1, component=1)
    for _ in range(2 * file_limit // len(raw)):
        writer.record(raw, link=0)
    writer.flush()
    writer.close()
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert "flight.tlog" in caplog.text
    size = path.stat().st_size
    assert 0 < size < file_limit
    assert size % (8 + len(raw)) == 0


def test_a_device_that_takes_nothing_does_not_end_the_flight(
    caplog: pytest.LogCaptureFixture,
) -> None:
    writer = TlogWriter(Path("/dev/full"), unix_epoch_us=0, clock=lambda: 0)
    writer.record(b"packet", link=1)
    writer.flush()
    writer.close()
    assert "No space left on device" in caplog.text
