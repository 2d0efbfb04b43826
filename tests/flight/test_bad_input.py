"""What cannot be is refused with one clear line and the right exit code."""

import contextlib
import shutil
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from flightstack.launch.instances import API_PORT, free_instance
from tests.flight.processes import Ended, process, run, run_module
from tests.paths import ROOT

pytestmark = pytest.mark.flight
USAGE, NO_LINK, BAD_MODEL = 2, 3, 4


def assert_one_line(ended: Ended, code: int, *fragments: str) -> None:
    assert ended.code == code, ended.stderr
    lines = ended.stderr.strip().splitlines()
    complaint = lines[-1] if lines else ""
    assert "Traceback" not in ended.stderr
    assert len([line for line in lines if not line.startswith(("usage:", " "))]) == 1, ended.stderr
    for fragment in fragments:
        assert fragment in complaint


@contextlib.contextmanager
def taken(kind: socket.SocketKind, port: int) -> Iterator[None]:
    with socket.socket(socket.AF_INET, kind) as holder:
        holder.bind(("127.0.0.1", port))
        if kind == socket.SOCK_STREAM:
            holder.listen()
        yield


@pytest.mark.parametrize("noise", ["one,two", "1.0", "-1,2", "nan,1", "1,2,3"])
def test_vehicle_refuses_a_wrong_noise(noise: str) -> None:
    assert_one_line(run_module("sitl", f"--noise={noise}"), USAGE, "noise")


def test_vehicle_refuses_a_busy_port() -> None:
    with free_instance() as instance, taken(socket.SOCK_DGRAM, 14580 + instance):
        ended = run_module("sitl", f"--instance={instance}")
    assert_one_line(ended, NO_LINK, str(14580 + instance))


def test_companion_refuses_a_busy_port() -> None:
    with free_instance() as instance, taken(socket.SOCK_DGRAM, API_PORT + instance):
        ended = run_module("flightstack.companion", f"--udp={API_PORT + instance}")
    assert_one_line(ended, NO_LINK, str(API_PORT + instance))


@pytest.mark.parametrize("address", ["nonsense", "udp:host", "99999", "ftp://host:21"])
def test_companion_refuses_a_malformed_connection_string(address: str) -> None:
    assert_one_line(run_module("flightstack.companion", f"--udp={address}"), USAGE, address)


def test_companion_refuses_an_unknown_model() -> None:
    ended = run_module("flightstack.companion", "--udp=14549", "--model=no/such")
    assert_one_line(ended, BAD_MODEL, "no/such")


def test_companion_refuses_an_unknown_strategy() -> None:
    ended = run_module("flightstack.companion", "--udp=14549", "--strategy=hope")
    assert_one_line(ended, USAGE, "hope")


def test_companion_refuses_damaged_weights(tmp_path: Path) -> None:
    model = tmp_path / "damaged"
    shutil.copytree(ROOT / "models" / "strong" / "m0", model)
    weights = bytearray((model / "encoder.onnx").read_bytes())
    weights[len(weights) // 2] ^= 0x01
    (model / "encoder.onnx").write_bytes(weights)
    ended = run_module("flightstack.companion", "--udp=14549", f"--model={model}")
    assert_one_line(ended, BAD_MODEL, str(model), "damaged")


@pytest.mark.parametrize("camera", ["http://127.0.0.1:9/stream", "/dev/video99", "no-such.mp4"])
def test_companion_refuses_a_camera_that_is_not_there(tmp_path: Path, camera: str) -> None:
    with free_instance() as instance:
        vehicle_options = (f"--instance={instance}", "--noise=0,0")
        companion_options = (f"--udp={API_PORT + instance}", f"--camera={camera}", "-q")
        with process("sitl", *vehicle_options, log=tmp_path / "vehicle.txt"):
            ended = run_module("flightstack.companion", *companion_options)
    assert_one_line(ended, NO_LINK, camera)


def test_fly_reports_an_unknown_model_and_leaves_no_process() -> None:
    command = [sys.executable, str(ROOT / "scripts" / "fly_course.py"), "--model=no/such", "--json"]
    ended = run(command, timeout_s=60.0)
    assert_one_line(ended, BAD_MODEL, "no/such")
    assert ended.result["outcome"] == "did not fly"


def test_fly_refuses_a_wrong_noise() -> None:
    command = [sys.executable, str(ROOT / "scripts" / "fly_course.py"), "--noise=much"]
    assert_one_line(run(command, timeout_s=60.0), USAGE, "noise")


def test_companion_refuses_a_log_that_cannot_be_written(tmp_path: Path) -> None:
    log = tmp_path / "file" / "flight.tlog"
    (tmp_path / "file").write_text("not a folder")
    ended = run_module("flightstack.companion", "--udp=14549", f"--log={log}")
    assert_one_line(ended, USAGE, str(log))
