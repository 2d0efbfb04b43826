"""`python -m sitl --autopilot px4` as a process, and a stand-in of PX4 at its port."""

import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import pytest

from tests.paths import ROOT
from tests.wire.px4_stand_in import ARMED, Px4StandIn
from tests.wire.stream_viewer import StreamViewer

HOVER = 0.62  # a little above: it climbs
ENDS_S = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Simulator:
    """The process, and where it is met."""

    process: subprocess.Popen[str]
    port: int
    camera: str
    address: str

    def read_until(self, words: str) -> str:
        """Read what it says up to a line with these words."""
        assert self.process.stderr is not None
        said = []
        for line in self.process.stderr:
            said.append(line)
            if words in line:
                return "".join(said)
        raise AssertionError("".join(said))


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    command = [sys.executable, "-m", "sitl", "--autopilot=px4", "--speed-factor=0"]
    process = subprocess.Popen(
        [*command, "--hil-port=0", "--camera-port=0"], cwd=ROOT, stderr=subprocess.PIPE, text=True
    )
    with process:
        try:
            assert process.stderr is not None
            line = process.stderr.readline()
            found = re.search(r"tcp ([\d.]+):(\d+), camera (\S+)", line)
            assert found is not None, line
            yield Simulator(process=process, port=int(found[2]), camera=found[3], address=found[1])
        finally:
            process.kill()


def test_it_listens_on_the_loopback_interface_alone(simulator: Simulator) -> None:
    assert simulator.address == "127.0.0.1"
    with socket.create_server(("127.0.0.2", simulator.port)):
        pass  # nobody has it


def test_every_tick_waits_for_its_answer(simulator: Simulator) -> None:
    with Px4StandIn(simulator.port) as px4:
        px4.fly(500)
        times = [message.time_usec for message in px4.sensors]
        assert times == list(range(4000, 4000 * 501, 4000))
        px4.fly(250, HOVER, ARMED)  # 1 s
        truths = [m for m in px4.others if m.get_type() == "HIL_STATE_QUATERNION"]
        assert truths[-1].alt > truths[0].alt + 100  # mm: what it flies by are these motors
        fixes = [m for m in px4.others if m.get_type() == "HIL_GPS"]
        assert len(fixes) == pytest.approx(3.0 * 8, abs=1)
    assert "PX4 has gone" in simulator.read_until("PX4 has gone")


def test_the_camera_looks_while_px4_flies(simulator: Simulator) -> None:
    with Px4StandIn(simulator.port) as px4, StreamViewer(simulator.camera) as viewer:
        first = viewer.read()
        px4.fly(100)
        later = viewer.read()
        assert later.time_us > first.time_us


def test_where_no_answer_comes_time_goes_on(simulator: Simulator) -> None:
    with Px4StandIn(simulator.port) as px4:
        for _ in range(50):  # as a PX4 that boots
            px4.await_sensors()
        px4.fly(50)
        for _ in range(50):  # as one in OFFBOARD that is disarmed
            px4.await_sensors()
        times_us = [each.time_usec for each in px4.sensors]
    assert len(times_us) >= 150
    assert {after - before for before, after in pairwise(times_us)} == {4000}


def test_another_px4_goes_on_in_the_same_time(simulator: Simulator) -> None:
    with Px4StandIn(simulator.port) as px4:
        px4.fly(20)
    assert "waiting for PX4 to connect" in simulator.read_until("waiting for PX4")
    with Px4StandIn(simulator.port) as another:
        another.fly(20)
        assert another.sensors[0].time_usec > px4.sensors[-1].time_usec


def test_strangers_are_refused_while_px4_flies(simulator: Simulator) -> None:
    with Px4StandIn(simulator.port) as px4:
        px4.fly(20)
        for _ in range(4):
            stranger = socket.create_connection(("127.0.0.1", simulator.port))
            stranger.settimeout(ENDS_S)
            px4.fly(20)
            with stranger:
                assert stranger.recv(1) == b""


@pytest.mark.parametrize("connected", [False, True])
def test_a_signal_ends_it_whatever_it_waits_for(simulator: Simulator, *, connected: bool) -> None:
    if not connected:
        simulator.read_until("waiting for PX4")
        simulator.process.terminate()
        assert simulator.process.wait(ENDS_S) == 0
        return
    with Px4StandIn(simulator.port) as px4:
        px4.fly(5, HOVER, ARMED)
        px4.await_sensors()  # and never answers
        simulator.process.terminate()
        assert simulator.process.wait(ENDS_S) == 0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--lockstep"], "--api-link"),
        (["--tcp=0"], "--tcp: not with --autopilot px4"),
        (["--perfect-estimate"], "PX4 estimates for itself"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(options: list[str], words: str) -> None:
    command = [sys.executable, "-m", "sitl", "--autopilot=px4", *options]
    refused = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert words in refused.stderr
    assert refused.stderr.count("\n") == 1
