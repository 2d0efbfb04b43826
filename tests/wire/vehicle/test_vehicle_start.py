"""How a vehicle's process begins and ends."""

import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from tests.paths import ROOT
from tests.wire.vehicle_process import Vehicle

pytestmark = pytest.mark.flight
FIRST_HEARTBEAT_S = 1.0
ATTEMPTS = 5  # the machine may be busy with something else


def run_to_end(*options: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sitl", "--gcs-link=0:9", "--api-link=0:9", *options],
        cwd=ROOT,
        env=environment or None,
        capture_output=True,
        text=True,
        timeout=30.0,
        check=False,
    )


def test_the_first_heartbeat_comes_within_a_second() -> None:
    delays_s = []
    for _ in range(ATTEMPTS):
        with Vehicle("-q") as vehicle:
            beat = vehicle.gcs.wait_for("HEARTBEAT")
            delays_s.append(time.monotonic() - vehicle.started_s)
            assert (beat.type, beat.autopilot, beat.custom_mode) == (2, 12, 0x03040000)
        if delays_s[-1] < FIRST_HEARTBEAT_S:
            return
    pytest.fail(f"first heartbeats after {delays_s} s")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 0)])
def test_a_signal_ends_it_with_its_log_whole(tmp_path: Path, number: int, code: int) -> None:
    log = tmp_path / "vehicle.tlog"
    with Vehicle(f"--log={log}", "-q") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.command(512, 148)
        vehicle.gcs.wait_for("AUTOPILOT_VERSION")
        assert vehicle.end(number) == (code, "")
    reader = mavutil.mavlink_connection(str(log))
    seen = set()
    while (message := reader.recv_match()) is not None:
        assert message.get_type() != "BAD_DATA"
        seen.add((message.get_srcSystem(), message.get_type()))
    reader.close()
    assert {(1, "ATTITUDE"), (1, "CAMERA_TRIGGER"), (42, "COMMAND_LONG")} <= seen


def test_it_says_in_one_line_where_it_is() -> None:
    with Vehicle() as vehicle:
        vehicle.wait_until_up()
        _, said = vehicle.end(signal.SIGTERM)
    first, last = said.splitlines()
    assert f"to {vehicle.gcs.port}" in first
    assert f"to {vehicle.api.port}" in first
    assert "/stream" in first
    assert "SIGTERM" in last


def test_a_busy_camera_port_is_refused() -> None:
    with socket.socket() as holder:
        holder.bind(("127.0.0.1", 0))
        holder.listen()
        port = holder.getsockname()[1]
        ended = run_to_end(f"--camera-port={port}")
    assert ended.returncode == 3
    (line,) = ended.stderr.splitlines()
    assert str(port) in line
    assert "--camera-port" in line


@pytest.mark.parametrize(
    ("option", "environment", "fragment"),
    [
        ("--noise=much", {}, "--noise"),
        ("--noise=50,0", {}, "50"),
        ("--log=/no/such/folder/file", {}, "--log"),
        ("--params=/no/such/folder/file", {}, "--params"),
        ("--gui", {"DISPLAY": ""}, "--gui"),
        ("-q", {"PX4_PARAM_MPC_XY_P": "often"}, "MPC_XY_P"),
        ("-q", {"PX4_PARAM_NO_SUCH": "1"}, "NO_SUCH"),
        ("-q", {"PX4_SIM_SPEED_FACTOR": "-1"}, "PX4_SIM_SPEED_FACTOR"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(
    option: str, environment: dict[str, str], fragment: str
) -> None:
    ended = run_to_end(option, "--camera-port=0", **environment)
    assert ended.returncode == 2
    (line,) = ended.stderr.splitlines()
    assert fragment in line
    assert ended.stdout == ""


def test_parameters_come_from_the_environment() -> None:
    environment = {"PX4_PARAM_MIS_TAKEOFF_ALT": "4.5"}
    with Vehicle("-q", environment=environment) as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.send(mavlink.MAVLink_param_request_read_message(1, 1, b"MIS_TAKEOFF_ALT", -1))
        assert vehicle.gcs.wait_for("PARAM_VALUE").param_value == 4.5
