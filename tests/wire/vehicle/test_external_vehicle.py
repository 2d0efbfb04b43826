"""`python -m sitl --autopilot external` as a process, and a vehicle that tells its true pose."""

import math
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sitl.frames import HOME, geodetic_from_ned
from sitl.records.motion import Vector3
from sitl.world.track import make_track
from tests.paths import ROOT
from tests.wire.stream_viewer import StreamViewer

GATE = make_track(0, radius_noise_m=0.0, height_noise_m=0.0, direction="cw").gates[0]
STEPS, STEP_US = 100, 4000
BAR_M = 0.7  # beside the centre of an opening of 1.2 m: there is a bar


class ToldVehicle:
    """Tells poses as PX4's SIH does: `time_usec` is 0, ATTITUDE comes first."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(("127.0.0.1", port))
        self._socket.settimeout(10.0)
        self._codec = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)

    def close(self) -> None:
        """Free the port."""
        self._socket.close()

    def tell(self, time_us: int, place: Vector3, yaw_rad: float) -> None:
        """Say where it is at a time of its own."""
        latitude, longitude, altitude = geodetic_from_ned(place, HOME)
        half = yaw_rad / 2.0
        pose = mavlink.MAVLink_hil_state_quaternion_message(
            0,
            [math.cos(half), 0.0, 0.0, math.sin(half)],
            *(0.0, 0.0, 0.0),
            *(round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1e3)),
            *(0, 0, 0, 0, 0, 0, 0, -1000),
        )
        attitude = mavlink.MAVLink_attitude_message(time_us // 1000, 0, 0, yaw_rad, 0, 0, 0)
        self._socket.send(attitude.pack(self._codec) + pose.pack(self._codec))

    def await_requests(self) -> list[Any]:
        """Read the two commands that ask for more."""
        requests: list[Any] = []
        while len(requests) < 2:
            requests += self._codec.parse_buffer(self._socket.recv(2048)) or []
        return requests


@dataclass(frozen=True, slots=True, kw_only=True)
class Follower:
    """The process, where it looks from, and the vehicle that it follows."""

    process: subprocess.Popen[str]
    camera: str
    vehicle: ToldVehicle

    def read_until(self, words: str) -> str:
        """Read what it says up to a line with these words."""
        assert self.process.stderr is not None
        for line in self.process.stderr:
            if words in line:
                return line
        raise AssertionError(f"never said: {words}")


@pytest.fixture
def follower() -> Iterator[Follower]:
    command = [sys.executable, "-m", "sitl", "--autopilot=external", "--noise=0,0"]
    process = subprocess.Popen(
        [*command, "--connect=udpin:127.0.0.1:0", "--camera-port=0"],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        assert process.stderr is not None
        line = process.stderr.readline()
        found = re.search(r"poses udp (\d+), camera (\S+)", line)
        assert found is not None, line
        vehicle = ToldVehicle(int(found[1]))
        try:
            yield Follower(process=process, camera=found[2], vehicle=vehicle)
        finally:
            vehicle.close()
            process.kill()


def fly_through(vehicle: ToldVehicle, start_us: int, *, right_m: float = 0.0) -> None:
    """Stand at the origin, then move through the plane of the first gate, beside its centre."""
    vehicle.tell(start_us, (0.0, 0.0, 0.0), 0.0)
    forward = (math.cos(GATE.yaw_rad), math.sin(GATE.yaw_rad))
    north, east, down = GATE.centre_ned
    for step in range(STEPS):
        along_m = (step - STEPS / 2) * 0.02
        place = (
            north + along_m * forward[0] - right_m * forward[1],
            east + along_m * forward[1] + right_m * forward[0],
            down,
        )
        vehicle.tell(start_us + (step + 1) * STEP_US, place, GATE.yaw_rad)


def test_it_asks_for_poses_and_judges_them_by_their_own_clock(follower: Follower) -> None:
    assert "vehicle 1 to tell its true pose" in follower.read_until("waiting for")
    fly_through(follower.vehicle, 5_000_000)
    requests = follower.vehicle.await_requests()
    assert [(r.get_type(), r.command) for r in requests] == [("COMMAND_LONG", 511)] * 2
    assert {r.param1 for r in requests} == {30, 115}  # ATTITUDE, HIL_STATE_QUATERNION
    assert "from 5.000 s of its time" in follower.read_until("tells its pose")
    assert "Passed gate 1 of 8" in follower.read_until("gate 1")


def test_a_vehicle_that_starts_anew_finds_the_course_as_it_was(follower: Follower) -> None:
    fly_through(follower.vehicle, 60_000_000)
    follower.read_until("Passed gate 1")
    fly_through(follower.vehicle, 1_000_000, right_m=BAR_M)
    assert "from 1.000 s" in follower.read_until("tells its pose")
    follower.read_until("Collision with gate 1")


def test_images_are_of_the_poses_and_bear_their_time(follower: Follower) -> None:
    with StreamViewer(follower.camera) as viewer:
        fly_through(follower.vehicle, 5_000_000)
        parts = [viewer.read() for _ in range(8)]
    assert [part.time_us for part in parts] == [
        5_000_000 + 50_000 * k + 2000 * (k % 2) for k in range(8)
    ]
    assert parts[0].data != parts[1].data


def test_it_ends_when_it_is_told_though_nobody_comes(follower: Follower) -> None:
    follower.process.terminate()
    assert follower.process.wait(10.0) == 0
