"""A server around a simulation without physics, over real sockets and a wall clock set by hand."""

import socket
from collections.abc import Callable
from typing import Any

import numpy as np

from sitl.clock import TICK_US, Schedule
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.udp_link import LinkConfig, UdpLink
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Received, pack, split, wrap
from sitl.process.lockstep import Lockstep
from sitl.process.server import Server
from sitl.process.streams.camera_stream import CameraStream
from sitl.records.images import Image, ImageStamp
from tests.unit.sitl.mavlink.fakes import FakeVehicle

IMAGE = np.zeros((64, 64, 3), np.uint8)


class FakeSimulation(FakeVehicle):
    """Time that passes, images that are black, and a hook after each tick."""

    def __init__(self) -> None:
        super().__init__()
        self.time_us = 0
        self._images = Schedule(20)
        self._sequence = 0
        self.ticked: Callable[[], None] = lambda: None

    def step(self) -> None:
        self.time_us += TICK_US
        self.ticked()

    def image_due(self) -> bool:
        return self._images.due(self.time_us)

    @property
    def image_stamp(self) -> ImageStamp:
        return ImageStamp(self.time_us, self._sequence)

    def render(self) -> Image:
        image = Image(time_us=self.time_us, sequence=self._sequence, rgb=IMAGE)
        self._sequence += 1
        return image


class WallClock:
    """Advances by itself a little each time it is looked at."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.looks = 0

    def __call__(self) -> float:
        self.looks += 1
        self.now_s += 1e-4
        return self.now_s


class Companion:
    """Looks at the images and answers them."""

    def __init__(self, stream: CameraStream, link: UdpLink, udp: socket.socket) -> None:
        self.udp = udp
        self.vehicle = ("127.0.0.1", link.local_port)
        self.tcp = socket.create_connection(("127.0.0.1", stream.port))
        self.tcp.sendall(b"GET /stream HTTP/1.1\r\n\r\n")
        self.tcp.settimeout(0.0)
        while not stream.has_viewers:
            stream.serve(1.0)

    def send(self, message: Any) -> None:
        raw = wrap(pack(message), sequence=0, system=1, component=191)
        self.udp.sendto(raw, self.vehicle)

    def command(self, number: int) -> None:
        self.send(mavlink.MAVLink_command_long_message(1, 1, number, 0, *[0.0] * 7))

    def answer(self, time_us: int) -> None:
        self.send(
            mavlink.MAVLink_set_position_target_local_ned_message(
                time_us // 1000, 1, 1, 8, 1479, *[0.0] * 11
            )
        )


class Bench:
    """A server and what it runs."""

    def __init__(self, *, lockstep: bool = False, speed_factor: float = 0.0) -> None:
        self.simulation = FakeSimulation()
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("127.0.0.1", 0))
        self.udp.settimeout(0.0)
        self.link = UdpLink(
            LinkConfig(name="api", local_port=0, remote_port=self.udp.getsockname()[1]),
            system=1,
            index=1,
        )
        self.stream = CameraStream(0)
        facts = CameraFacts(
            stream_uri=self.stream.uri,
            width_px=64,
            height_px=64,
            field_of_view_deg=90,
            rate_hz=20.0,
        )
        ground = UdpLink(LinkConfig(name="gcs", local_port=0, remote_port=9), system=1, index=0)
        links = [ground, self.link]
        self.links = links
        self.clock = WallClock()
        self.endpoint = Endpoint(self.simulation, links, system=1, camera=facts)
        self.server = Server(
            self.simulation,
            self.endpoint,
            links,
            self.stream,
            speed_factor=speed_factor,
            lockstep=Lockstep() if lockstep else None,
            clock=self.clock,
        )

    def close(self) -> None:
        for link in self.links:
            link.close()
        self.stream.close()
        self.udp.close()

    def stop_at(self, time_us: int) -> None:
        def check() -> None:
            if self.simulation.time_us >= time_us:
                self.server.stop()

        self.simulation.ticked = check

    def note_commands(self) -> list[tuple[int, int]]:
        """Note from now on when which command is handled: time in us, its number."""
        handled: list[tuple[int, int]] = []
        command = self.simulation.autopilot.command

        def note(asked: Any) -> Any:
            handled.append((self.simulation.time_us, asked.command))
            return command(asked)

        self.simulation.autopilot.command = note  # type: ignore[method-assign, assignment]
        return handled

    def received(self) -> list[Any]:
        return [item.message for item in self.arrived()]

    def arrived(self) -> list[Received]:
        items: list[Received] = []
        while True:
            try:
                items += split(self.udp.recv(2048))
            except BlockingIOError:
                return items
