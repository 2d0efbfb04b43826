"""File transfer and log download of a vehicle process, by pymavlink's and MAVSDK's clients."""

import json
import logging
import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.log_files import LogFiles
from mavsdk.plugins.log_files.log_files import LogFilesResult
from pymavlink import mavutil
from pymavlink.mavftp import MAVFTP, FtpError

from tests.wire.vehicle_process import Vehicle, is_acknowledgement, is_text

pytestmark = pytest.mark.flight
ARMED = 128


class Bench:
    """A vehicle that has flown once, with its ground station's port left for others."""

    def __init__(self, vehicle: Vehicle, folder: Path) -> None:
        self.vehicle = vehicle
        self.folder = folder
        self.port = vehicle.gcs.port
        vehicle.gcs.socket.close()

    @property
    def log(self) -> Path:
        (log,) = (self.folder / "log").iterdir()
        return log


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("vehicle") / "files"
    with Vehicle("--speed-factor=3", f"--files={folder}") as vehicle:
        api = vehicle.api
        api.wait_for("ATTITUDE", timeout_s=30.0)
        api.say_hello()
        api.wait_for(is_text("Ready for takeoff"), timeout_s=30.0)
        api.command(400, 1)
        api.wait_for(is_acknowledgement(400))
        for _ in range(3):
            api.wait_for(lambda m: _is_beat(m) and m.base_mode & ARMED)
        api.command(400, 0)
        for _ in range(2):
            api.wait_for(lambda m: _is_beat(m) and not m.base_mode & ARMED)
        yield Bench(vehicle, folder)


def _is_beat(message: Any) -> bool:
    return bool(message.get_type() == "HEARTBEAT" and message.get_srcComponent() == 1)


@pytest.fixture
def ftp(bench: Bench) -> Iterator[MAVFTP]:
    link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{bench.port}", dialect="development")
    link.wait_heartbeat(timeout=10.0)
    link.target_system = 1
    before = logging.getLogger().level
    yield MAVFTP(link, 1, 1)
    logging.getLogger().setLevel(before)
    link.close()


def fetch(ftp: MAVFTP, path: str, target: Path) -> int:
    ftp.cmd_get([path, str(target)])
    return int(ftp.process_ftp_reply("OpenFileRO", timeout=20).error_code)


def test_pymavlink_fetches_what_is_there(bench: Bench, ftp: MAVFTP, tmp_path: Path) -> None:
    listed = ftp.cmd_list(["/"]).directory_listing
    assert {entry.name for entry in listed} == {"log", "general.json", "parameters.json"}
    (entry,) = ftp.cmd_list(["/log"]).directory_listing
    assert (entry.name, entry.size_b) == (bench.log.name, bench.log.stat().st_size)
    assert fetch(ftp, f"/log/{entry.name}", tmp_path / "log") == FtpError.Success
    assert (tmp_path / "log").read_bytes() == bench.log.read_bytes()
    assert fetch(ftp, "/general.json", tmp_path / "general") == FtpError.Success
    (described,) = json.loads((tmp_path / "general").read_text())["metadataTypes"]
    assert fetch(ftp, described["uri"].removeprefix("mftp://"), tmp_path / "p") == FtpError.Success
    names = {row["name"] for row in json.loads((tmp_path / "p").read_text())["parameters"]}
    assert {"MAV_SYS_ID", "COM_OF_LOSS_T"} <= names
    assert ftp.cmd_crc(["/parameters.json"]).error_code == FtpError.Success


def test_pymavlink_gets_nothing_else(ftp: MAVFTP, tmp_path: Path) -> None:
    assert fetch(ftp, "../../../etc/passwd", tmp_path / "x") == FtpError.FileProtected
    assert fetch(ftp, "/etc/passwd", tmp_path / "x") == FtpError.FileNotFound
    assert ftp.cmd_rm(["/parameters.json"]).error_code == FtpError.UnknownCommand
    assert ftp.cmd_mkdir(["/new"]).error_code == FtpError.UnknownCommand


def test_the_log_is_of_the_flight(bench: Bench) -> None:
    log = mavutil.mavlink_connection(str(bench.log), robust_parsing=True, dialect="development")
    beats = []
    while (message := log.recv_match(type="HEARTBEAT")) is not None:
        if message.get_srcComponent() == 1:
            beats.append(bool(message.base_mode & ARMED))
    log.close()
    assert beats.count(True) >= 3


def test_mavsdk_downloads_the_log(bench: Bench, tmp_path: Path) -> None:
    kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
    with Mavsdk(kind) as mavsdk:
        mavsdk.add_any_connection(f"udpin://127.0.0.1:{bench.port}")
        found = mavsdk.first_autopilot(timeout_s=10.0)
        assert found is not None
        logs = LogFiles(found)
        (entry,) = logs.get_entries()
        assert entry.size_bytes == bench.log.stat().st_size
        results: queue.SimpleQueue[LogFilesResult] = queue.SimpleQueue()
        target = tmp_path / "mavsdk.tlog"
        logs.download_log_file_async(
            entry, str(target), lambda result, *_: results.put(LogFilesResult(result))
        )
        while (result := results.get(timeout=30.0)) is LogFilesResult.NEXT:
            pass
        assert result is LogFilesResult.SUCCESS
        assert target.read_bytes() == bench.log.read_bytes()
