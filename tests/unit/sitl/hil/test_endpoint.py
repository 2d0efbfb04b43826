from collections.abc import Iterator
from typing import Any

import pytest

from sitl.hil.connection import Px4Connection
from sitl.hil.endpoint import ComponentsEndpoint
from sitl.hil.relay import CompanionLink
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.links.link import Guard
from sitl.mavlink.wire.dialect import CAMERA, REFEREE, mavlink
from sitl.mavlink.wire.packets import pack, split, wrap
from sitl.records.images import ImageStamp
from tests.unit.sitl.hil.test_relay import Relay
from tests.unit.sitl.mavlink.fakes import FakeVehicle
from tests.wire.px4_stand_in import Px4StandIn

FACTS = CameraFacts(
    stream_uri="http://x/stream", width_px=64, height_px=64, field_of_view_deg=90, rate_hz=20.0
)


class Bench:
    """An endpoint on a relay, with a wall clock that is set by hand."""

    def __init__(self, connection: Px4Connection) -> None:
        self.relay = Relay()
        self.vehicle = FakeVehicle()
        self.now_s = 0.0
        self.connection = connection
        link: CompanionLink = self.relay.link
        self.endpoint = ComponentsEndpoint(
            self.vehicle,
            connection,
            system=1,
            camera=FACTS,
            guard=Guard(),
            relay=(link, self.relay.px4_side),
            clock=lambda: self.now_s,
        )

    def companion_says(self, message: Any) -> None:
        raw = wrap(pack(message), sequence=0, system=1, component=191)
        self.relay.companion.sendto(raw, ("127.0.0.1", self.relay.link.local_port))
        while not self.endpoint.receive(self.relay.link):
            pass

    def heard(self) -> list[tuple[int, Any]]:
        self.relay.companion.settimeout(0.0)
        items: list[tuple[int, Any]] = []
        while True:
            try:
                datagram = self.relay.companion.recv(4096)
            except BlockingIOError:
                return items
            items += [(item.component, item.message) for item in split(datagram)]


@pytest.fixture
def bench(connection: Px4Connection) -> Iterator[Bench]:
    bench = Bench(connection)
    yield bench
    bench.relay.close()


def test_camera_and_referee_stand_beside_px4(bench: Bench) -> None:
    bench.endpoint.publish()
    heard = [(component, message.get_type()) for component, message in bench.heard()]
    assert (CAMERA, "HEARTBEAT") in heard
    assert (REFEREE, "HEARTBEAT") in heard
    assert (REFEREE, "MISSION_CURRENT") in heard


def test_they_answer_what_is_meant_for_them_and_px4_gets_it_too(bench: Bench) -> None:
    bench.companion_says(mavlink.MAVLink_command_long_message(1, CAMERA, 512, 0, 269, *[0.0] * 6))
    bench.companion_says(mavlink.MAVLink_mission_request_list_message(1, REFEREE, 0))
    bench.companion_says(mavlink.MAVLink_mission_request_int_message(1, REFEREE, 0, 0))
    bench.companion_says(mavlink.MAVLink_command_long_message(1, 1, 400, 0, *[0.0] * 7))
    heard = [(component, message.get_type()) for component, message in bench.heard()]
    assert heard == [
        (CAMERA, "VIDEO_STREAM_INFORMATION"),
        (CAMERA, "COMMAND_ACK"),
        (REFEREE, "MISSION_COUNT"),
        (REFEREE, "MISSION_ITEM_INT"),
    ]
    passed_on = [split(bench.relay.px4.recv(4096))[0].message.get_type() for _ in range(4)]
    assert passed_on[-1] == "COMMAND_LONG"


def test_a_setpoint_answers_the_image_whose_stamp_it_has(bench: Bench) -> None:
    bench.vehicle.time_us = 100_000
    assert bench.endpoint.take_answer() == -1
    for time_ms in (48, 100, 200):  # the last cannot be: nobody has seen that image
        bench.companion_says(
            mavlink.MAVLink_set_position_target_local_ned_message(
                time_ms, 1, 1, 8, 1479, *[0.0] * 11
            )
        )
    assert bench.endpoint.take_answer() == 100_000
    assert bench.endpoint.take_answer() == -1


def test_an_image_waits_for_px4s_attitude_of_its_time(bench: Bench) -> None:
    def attitude(time_ms: int) -> None:
        message = mavlink.MAVLink_attitude_message(time_ms, 0.1, *[0.1] * 5)
        raw = wrap(pack(message), sequence=0, system=1, component=1)
        bench.relay.px4.sendto(raw, ("127.0.0.1", bench.relay.px4_side.local_port))

    bench.vehicle.time_us = 100_000
    attitude(80)
    bench.relay.px4_side.serve(1.0)
    attitude(92)
    bench.endpoint.publish_trigger(ImageStamp(100_000, 7))
    kinds = [message.get_type() for _, message in bench.heard()]
    assert kinds == ["ATTITUDE", "ATTITUDE", "CAMERA_TRIGGER"]


def test_it_says_what_it_waits_for_and_not_all_the_time(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    assert not bench.endpoint.is_ready
    for second in range(7):
        bench.now_s = float(second)
        bench.endpoint.repeat_heartbeats()
    host, port = bench.connection.address
    assert caplog.text.count(f"waiting for PX4 to connect to tcp {host}:{port}") == 2
    with Px4StandIn(port):
        while not bench.endpoint.is_ready:
            bench.connection.serve(1.0)
