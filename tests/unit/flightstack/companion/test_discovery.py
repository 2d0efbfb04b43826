"""Vehicle and camera are awaited for as long as the caller says, by the caller's clock."""

from collections.abc import Callable
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.opening import discovery
from flightstack.companion.opening.discovery import (
    find_camera,
    wait_for_camera,
    wait_for_image,
    wait_for_vehicle,
)
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import LinkError, UsageError
from tests.unit.flightstack.companion.made_flight import MadeCamera
from tests.unit.flightstack.mavlink.made_link import VEHICLE, MadeLink, heartbeat

URI = "http://10.0.0.1/stream"


class Waiting:
    """A session on a made link; each wait moves the wall clock, and may bring something."""

    def __init__(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch, *, system: int | None = None
    ) -> None:
        self.made = MadeLink(folder, system=system)
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


def attitude(time_ms: int) -> object:
    return common.MAVLink_attitude_message(time_ms, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


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


OTHER = ("10.0.0.2", 14580)


def test_the_one_that_has_a_camera_is_taken_of_two_vehicles(waiting: Waiting) -> None:
    made, session = waiting.made, waiting.session
    made.say(attitude(900_000), system=2, address=OTHER)
    made.say(heartbeat(base_mode=157), system=2, address=OTHER)  # armed
    made.say(attitude(900_100), system=2, address=OTHER)
    made.say(heartbeat(), system=3)
    wait_for_vehicle(session, 60.0, name="udp")
    assert (session.link.system_id, session.telemetry.armed) == (2, True)
    waiting.brings[2.7] = lambda: made.say(stream(), system=3, component=100)
    waiting.brings[2.6] = lambda: made.say(attitude(5_000), system=3)
    assert find_camera(session, 60.0) == URI
    session.link.settle()
    assert (session.link.system_id, made.transport.partner) == (3, VEHICLE)
    assert not session.telemetry.armed  # which the other one was
    assert session.link.clock.stamp_us == 5_000_000
    assert session.link.restarts == 0
    assert [str(each) for each in session.link.heard] == [
        "system 2 at 10.0.0.2:14580",
        "system 3 at 10.0.0.1:14580",
    ]


def test_two_vehicles_of_one_number_are_told_apart_by_where_they_are(waiting: Waiting) -> None:
    made, session = waiting.made, waiting.session
    made.say(heartbeat(), address=OTHER)
    made.say(heartbeat())
    wait_for_vehicle(session, 60.0, name="udp")
    waiting.brings[0.6] = lambda: made.say(stream(), component=100)  # not of whom we speak with
    waiting.brings[3.1] = lambda: made.say(stream(), component=100)
    assert find_camera(session, 60.0) == URI
    assert waiting.waited_s > 3.0
    assert session.link.vehicle == session.link.heard[1]


def test_nobody_else_is_taken_than_the_system_that_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waiting = Waiting(tmp_path, monkeypatch, system=3)
    waiting.made.say(heartbeat(), system=2, address=OTHER)
    with pytest.raises(LinkError, match=r"no vehicle .*; looked past: system 2 at 10\.0\.0\.2"):
        wait_for_vehicle(waiting.session, 5.0, name="udp")
    waiting.made.say(heartbeat(), system=3)
    wait_for_vehicle(waiting.session, 5.0, name="udp")
    with pytest.raises(LinkError, match="the vehicle named no camera stream"):
        find_camera(waiting.session, 5.0)
    assert waiting.session.link.system_id == 3


@pytest.mark.parametrize(("autopilot", "called"), [(3, "an ArduPilot"), (4, "no PX4")])
def test_another_autopilot_is_looked_past(waiting: Waiting, autopilot: int, called: str) -> None:
    waiting.made.say(heartbeat(autopilot=autopilot), system=2, address=OTHER)
    waiting.brings[2.0] = lambda: waiting.made.say(heartbeat())
    wait_for_vehicle(waiting.session, 60.0, name="udp")
    assert waiting.session.link.system_id == 3
    assert called in str(waiting.session.link.heard[0])


def test_of_a_flood_of_vehicles_not_all_are_remembered(waiting: Waiting) -> None:
    for port in range(1000):
        waiting.made.say(heartbeat(), address=("10.0.0.9", port))
    wait_for_vehicle(waiting.session, 60.0, name="udp")
    assert len(waiting.session.link.heard) == 32


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
