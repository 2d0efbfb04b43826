"""A video file is played at its own rate, by the clock that it is given."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.camera.capture import CaptureSource
from flightstack.clock import VehicleClock

RATE_HZ = 50.0


class PatientClock:
    """A wall clock, and an event that nobody sets: to wait for it moves the clock."""

    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s

    def wait(self, timeout_s: float) -> bool:
        self.now_s += timeout_s
        return False

    def is_set(self) -> bool:
        return False

    def set(self) -> None:
        """Nobody waits in another thread."""


@pytest.fixture
def video(tmp_path: Path) -> str:
    path = str(tmp_path / "flight.avi")
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), RATE_HZ, (64, 64))
    for _ in range(5):
        writer.write(np.zeros((64, 64, 3), np.uint8))
    writer.release()
    return path


def test_a_file_is_played_at_its_own_rate(video: str, monkeypatch: pytest.MonkeyPatch) -> None:
    wall = PatientClock()
    source = CaptureSource(video, VehicleClock(wall))
    monkeypatch.setattr(source, "_closed", wall)
    received_s = [source.read().received_s for _ in range(3)]
    assert received_s == pytest.approx([100.0, 100.0 + 1 / RATE_HZ, 100.0 + 2 / RATE_HZ])


def test_a_file_that_is_read_late_does_not_hurry(
    video: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    wall = PatientClock()
    source = CaptureSource(video, VehicleClock(wall))
    monkeypatch.setattr(source, "_closed", wall)
    source.read()
    wall.now_s += 10.0
    received_s = [source.read().received_s for _ in range(3)]
    assert received_s == pytest.approx([110.0, 110.0, 110.0 + 1 / RATE_HZ])
