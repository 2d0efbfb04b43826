"""A camera that lies, breaks off, or has a clock of its own, between real processes."""

import re
from pathlib import Path

import pytest

from tests.flight.camera.past_proxy import fly_past

pytestmark = pytest.mark.flight
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


def test_the_same_picture_for_ever_is_held_for_and_landed(tmp_path: Path) -> None:
    result, said, code, _ = fly_past(tmp_path, Frozen())
    assert (result["outcome"], code) == ("camera_lost", 3)
    assert said.count("warning: the camera shows the same picture again and again") == 1
    assert "Traceback" not in said


def test_a_stream_that_breaks_and_errs_is_opened_again_and_flown_on_by(tmp_path: Path) -> None:
    result, said, code, connections = fly_past(tmp_path, breaks_off_and_errs)
    assert (result["outcome"], result["gates_passed"], code) == ("completed", 8, 0)
    assert connections == 3
    assert said.count("warning: the camera broke off") == 1
    assert said.count("warning: the camera's stamps are no time of this vehicle") == 1
