"""Vehicle and camera are awaited for as long as the caller says, by the caller's clock."""

from collections.abc import Callable
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion import discovery
from flightstack.companion.discovery import (
    find_camera,
    wait_for_camera,
    wait_for_image,
    wait_for_vehicle,
)
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import LinkError, UsageError
from tests.unit.flightstack.companion.made_flight import MadeCamera
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

URI = "http://10.0.0.1/stream"


class Waiting:
    """A session on a made link; each wait moves the wall clock, and may bring something."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.made = MadeLink(folder)
        self.session = VehicleSession(self.made.link, 3.0)
        self.began_s = self.made.wall.now_s
        self.brings: dict[float, Callable[[], object]] = {}  # after so many seconds
        monkeypatch.setattr(discovery, "wait_for_any", self._wait)

    @property
    def waited_s(self) -> float:
        return self.made.wall.now_s - self.began_s

    def _wait(self, timeout_s: float, *_: object) -> bool:
        self.made.wall.now_s += timeout_s
        for after_s in [each for each in self.brings if each <= self.waited_s]:
            self.brings.pop(after_s)()
        return False


@pytest.fixture
def waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Waiting:
    return Waiting(tmp_path, monkeypatch)


def stream() -> object:
    return common.MAVLink_video_stream_information_message(
        *(1, 1, 0, 1, 20.0, 64, 64, 0, 0, 90, b"camera", URI.encode())
    )


def test_a_vehicle_is_found_when_it_speaks(waiting: Waiting) -> None:
    waiting.brings[3.0] = lambda: waiting.made.say(heartbeat())
    wait_for_vehicle(waiting.session, 60.0, name="udp")
    assert waiting.waited_s == pytest.approx(3.0, abs=0.1)


def test_a_vehicle_that_is_silent_is_given_up_in_time(waiting: Waiting) -> None:
    with pytest.raises(LinkError, match="no vehicle heard on udp for 5 s; is it running"):
        wait_for_vehicle(waiting.session, 5.0, name="udp")
    assert waiting.waited_s == pytest.approx(5.0)


def test_a_camera_is_requested_twice_a_second_until_it_answers(waiting: Waiting) -> None:
    waiting.brings[1.2] = lambda: waiting.made.say(stream(), component=100)
    waiting.made.say(heartbeat())
    waiting.session.receive()
    assert find_camera(waiting.session, 60.0) == URI
    requests = [m for m in waiting.made.sent() if m.get_type() == "COMMAND_LONG"]
    assert len(requests) == 3
    assert {(m.command, m.param1, m.target_component) for m in requests} == {(512, 269, 100)}


def test_a_camera_that_nobody_names_is_given_up_in_time(waiting: Waiting) -> None:
    with pytest.raises(LinkError, match="named no camera stream for 2 s"):
        find_camera(waiting.session, 2.0)
    assert waiting.waited_s == pytest.approx(2.0)


def test_a_camera_that_cannot_be_opened_is_tried_until_the_time_is_over(waiting: Waiting) -> None:
    with pytest.raises(LinkError, match="cannot be reached"):
        wait_for_camera(waiting.session, "no-such.avi", 2.0)
    assert waiting.waited_s == pytest.approx(2.0)


def test_a_camera_without_images_is_given_up_in_time(waiting: Waiting) -> None:
    with pytest.raises(LinkError, match="camera front gave no frame for 4 s"):
        wait_for_image(waiting.session, MadeCamera(), 4.0, name="front")
    assert waiting.waited_s == pytest.approx(4.0)


def test_a_camera_at_fault_is_told_at_once(waiting: Waiting) -> None:
    camera = MadeCamera()
    camera.fault = UsageError("calibrate it")
    with pytest.raises(UsageError, match="calibrate it"):
        wait_for_image(waiting.session, camera, 4.0, name="front")
    assert waiting.waited_s == 0.0
