"""The log: whole records, readable by pymavlink, on disk within a second, and never fatal."""

import signal
import struct
import subprocess
import sys
from pathlib import Path

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common

from flightstack.errors import UsageError
from flightstack.mavlink.tlog import TlogWriter
from tests.unit.flightstack.small_disk import small_disk

PACKET = bytes(
    common.MAVLink_heartbeat_message(2, 12, 81, 0, 3, 3).pack(common.MAVLink(None, 1, 1))
)
RECORD_BYTES = 8 + len(PACKET)


class Wall:
    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_pymavlink_reads_it(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "a.tlog")
    for elapsed_us in (0, 500_000, 1_000_000):
        log.append(elapsed_us, PACKET)
    log.close()
    reader = mavutil.mavlink_connection(str(log.path), dialect="common")
    times = [reader.recv_match()._timestamp for _ in range(3)]
    assert reader.recv_match() is None
    reader.close()
    assert times[2] - times[0] == pytest.approx(1.0, abs=1e-5)


def test_times_leave_the_link_bits_clear(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "a.tlog")
    for elapsed_us in range(4):
        log.append(elapsed_us, PACKET)
    log.close()
    content = log.path.read_bytes()
    starts = range(0, len(content), RECORD_BYTES)
    assert all(struct.unpack_from(">Q", content, at)[0] % 4 == 0 for at in starts)


def test_is_on_disk_half_a_second_later(tmp_path: Path) -> None:
    wall = Wall()
    log = TlogWriter(tmp_path / "a.tlog", wall)
    log.append(0, PACKET)
    log.flush_if_due()
    assert log.path.stat().st_size == 0
    wall.now_s = 0.5
    log.flush_if_due()
    assert log.path.stat().st_size == RECORD_BYTES
    log.close()


def test_makes_the_folder(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "logs" / "today" / "a.tlog")
    log.append(0, PACKET)
    log.close()
    log.close()
    assert log.path.stat().st_size == RECORD_BYTES


def test_a_long_log_goes_on_in_further_files(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "a.tlog", max_bytes=2 * RECORD_BYTES)
    for _ in range(5):
        log.append(0, PACKET)
        log.flush()
    log.close()
    parts = [tmp_path / name for name in ("a.tlog", "a.1.tlog", "a.2.tlog")]
    assert sorted(tmp_path.iterdir()) == sorted(parts)
    assert [part.stat().st_size // RECORD_BYTES for part in parts] == [2, 2, 1]
    assert log.failure is None


def test_a_file_that_cannot_follow_ends_the_log(tmp_path: Path) -> None:
    (tmp_path / "a.1.tlog").mkdir()
    log = TlogWriter(tmp_path / "a.tlog", max_bytes=RECORD_BYTES)
    for _ in range(3):
        log.append(0, PACKET)
        log.flush()
    log.close()
    assert log.failure is not None
    assert "a.1.tlog: Is a directory" in log.failure
    assert log.path.stat().st_size == RECORD_BYTES


def test_leaves_no_empty_file(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "a.tlog")
    log.close()
    assert not log.path.exists()


def test_refuses_a_path_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot write the log .*Is a directory"):
        TlogWriter(tmp_path)


WRITE_AND_DIE = """
import os, pathlib, signal, sys
from flightstack.mavlink.tlog import TlogWriter
log = TlogWriter(pathlib.Path(sys.argv[1]))
for _ in range(100):
    log.append(0, bytes.fromhex(sys.argv[2]))
log.flush()
log.append(0, bytes.fromhex(sys.argv[2]))
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_survives_a_kill_up_to_the_last_flush(tmp_path: Path) -> None:
    path = tmp_path / "a.tlog"
    command = [sys.executable, "-c", WRITE_AND_DIE, str(path), PACKET.hex()]
    ended = subprocess.run(command, check=False)
    assert ended.returncode == -signal.SIGKILL
    assert path.stat().st_size == 100 * RECORD_BYTES


def test_a_full_disk_ends_the_log_at_a_whole_record(tmp_path: Path) -> None:
    log = TlogWriter(tmp_path / "a.tlog")
    with small_disk(100):
        log.append(0, PACKET)
        log.flush()
        for _ in range(100 // RECORD_BYTES + 1):
            log.append(0, PACKET)
        log.flush()
    assert log.failure is not None
    assert str(log.path) in log.failure
    log.append(0, PACKET)
    log.close()
    assert log.path.stat().st_size == RECORD_BYTES


def test_a_device_without_space_is_no_drama() -> None:
    log = TlogWriter(Path("/dev/full"))
    log.append(0, PACKET)
    log.close()
    assert log.failure == "the log /dev/full ends here: No space left on device"
