"""Cameras without stamps of the vehicle fly it in real time: H.264 over RTP, and plain MJPEG."""

import contextlib
import json
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from flightstack.launch.instances import API_PORT, free_instance
from tests.flight import tlogs
from tests.flight.processes import process, run_module
from tests.wire.camera_proxy import CameraProxy, Unstamped

pytestmark = pytest.mark.flight
LIMIT_S, FLIES_S = 60.0, 8.0
COMPANION = (f"--duration={FLIES_S:g}", "--no-landing", "--json")


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


@contextlib.contextmanager
def flight(folder: Path, instance: int, camera: str, *vehicle: str) -> Iterator[Any]:
    """Start both, in real time; give the companion."""
    folder.mkdir()
    options = (f"--instance={instance}", "--noise=0,0", *vehicle)
    companion = (f"--udp={API_PORT + instance}", f"--log={folder / 'flight.tlog'}")
    with (
        process("sitl", *options, log=folder / "vehicle.txt"),
        process(
            *("flightstack.companion", *companion, f"--camera={camera}", *COMPANION),
            log=folder / "companion.txt",
        ) as started,
    ):
        yield started


def judge(folder: Path) -> None:
    said = (folder / "companion.txt").read_text()
    result = json.loads(said.splitlines()[-1])
    assert (result["outcome"], result["gates_passed"] >= 1) == ("timeout", True), said
    messages = tlogs.read(folder / "flight.tlog")
    answers = [m for m in tlogs.of_type(messages, "TIMESYNC") if m.get_srcComponent() == 1]
    assert len([m for m in answers if m.tc1]) > 50
    summary = run_module("flightstack.logs", "summary", "--json", str(folder / "flight.tlog"))
    offboard = summary.result["offboard"]
    assert offboard["decisions"] > 0.7 * 20 * FLIES_S
    assert 0.0 <= offboard["frame_age_ms"]["p50"] < 50.0


def test_h264_over_rtp_and_mjpeg_without_stamps_pass_gates(tmp_path: Path) -> None:
    pytest.importorskip("av")
    port = free_port()
    video, plain = tmp_path / "video", tmp_path / "plain"
    with contextlib.ExitStack() as stack:
        enter = stack.enter_context
        instances = [enter(free_instance()) for _ in range(2)]
        proxy = enter(CameraProxy(Unstamped()))
        proxy.vehicle_instance = instances[1]
        address = f"udp://127.0.0.1:{port}"
        companions = [
            enter(flight(video, instances[0], address, f"--video={address}")),
            enter(flight(plain, instances[1], proxy.uri.replace("/stream", "/stream.mjpg"))),
        ]
        for companion in companions:
            companion.wait(LIMIT_S)
    judge(video)
    judge(plain)
