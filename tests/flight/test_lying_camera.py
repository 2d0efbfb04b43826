"""A camera that lies, breaks off, or has a clock of its own, between real processes."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.flight import tlogs
from tests.flight.processes import ENDS_S, pair
from tests.wire.camera_proxy import CameraProxy, Change

pytestmark = pytest.mark.flight
LIMIT_S = 60.0
IN_FLIGHT = 260  # images; in lockstep the vehicle is in OFFBOARD by then
STAMP = re.compile(rb"X-Timestamp: ([0-9.]+)")


class Frozen:
    """Sends the same picture for ever from some image on, under the stamps that come."""

    def __init__(self) -> None:
        self._picture: bytes | None = None

    def __call__(self, number: int, part: bytes) -> bytes:
        head, gap, picture = part.partition(b"\r\n\r\n")
        if number < IN_FLIGHT:
            return part
        self._picture = self._picture or picture
        return head + gap + self._picture


def breaks_off_and_errs(number: int, part: bytes) -> bytes | None:
    """Hang up twice; now and then send the time since 1970, and what is no time at all."""
    if number in (IN_FLIGHT, IN_FLIGHT + 25):
        return None
    if number % 20 == 0:
        return STAMP.sub(rb"X-Timestamp: 1733050000.25", part)
    return STAMP.sub(rb"X-Timestamp: -inf", part) if number % 20 == 10 else part


def fly(folder: Path, change: Change, *options: str) -> tuple[dict[str, Any], str, int, Any]:
    """Fly a lap past a camera; the result, all that was said, the code, the vehicle's log."""
    with CameraProxy(change) as proxy:
        companion = (f"--camera={proxy.uri}", "--json", *options)
        with pair(folder, "--noise=0,0", companion=companion) as flight:
            proxy.vehicle_instance = flight.instance
            code = flight.companion.wait(LIMIT_S)
            flight.vehicle.terminate()
            flight.vehicle.wait(ENDS_S)
            said = flight.companion_output.read_text()
    messages = tlogs.of_type(tlogs.read(flight.vehicle_log), "HEARTBEAT")
    beats = [m for m in messages if m.get_srcComponent() == 1]
    assert not beats[-1].base_mode & 128, "the vehicle is left armed"
    return json.loads(said.splitlines()[-1]), said, code, proxy.connections


def test_the_same_picture_for_ever_is_held_for_and_landed(tmp_path: Path) -> None:
    result, said, code, _ = fly(tmp_path, Frozen())
    assert (result["outcome"], code) == ("camera_lost", 3)
    assert said.count("warning: the camera shows the same picture again and again") == 1
    assert "Traceback" not in said


def test_a_stream_that_breaks_and_errs_is_opened_again_and_flown_on_by(tmp_path: Path) -> None:
    result, said, code, connections = fly(tmp_path, breaks_off_and_errs)
    assert (result["outcome"], result["gates_passed"], code) == ("completed", 8, 0)
    assert connections == 3
    assert said.count("warning: the camera broke off") == 1
    assert said.count("warning: the camera's stamps are no time of this vehicle") == 1
