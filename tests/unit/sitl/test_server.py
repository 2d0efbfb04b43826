"""The loop around a simulation without physics, over real sockets and a wall clock set by hand."""

import socket
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from sitl.camera_stream import CameraStream
from sitl.clock import SECOND_US, TICK_US, Schedule
from sitl.mavlink.camera_component import CameraFacts
from sitl.mavlink.dialect import mavlink
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.framing import Received, frame, pack, split
from sitl.mavlink.udp_link import LinkConfig, UdpLink
from sitl.records import Frame
from sitl.server import Server
from tests.unit.sitl.mavlink.fakes import FakeVehicle

IMAGE = np.zeros((64, 64, 3), np.uint8)


class FakeSimulation(FakeVehicle):
    """Time that passes, images that are black, and a hook after each tick."""

    def __init__(self) -> None:
        super().__init__()
        self._frames = Schedule(20)
        self._sequence = 0
        self.ticked: Callable[[], None] = lambda: None

    def step(self) -> None:
        self.time_us += TICK_US
        self.ticked()

    def frame_due(self) -> bool:
        return self._frames.due(self.time_us)

    def render(self) -> Frame:
        image = Frame(time_us=self.time_us, sequence=self._sequence, rgb=IMAGE)
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
        raw = frame(pack(message), sequence=0, system=1, component=191)
        self.udp.sendto(raw, self.vehicle)

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
            lockstep=lockstep,
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

    def received(self) -> list[Any]:
        return [item.message for item in self.arrived()]

    def arrived(self) -> list[Received]:
        items: list[Received] = []
        while True:
            try:
                items += split(self.udp.recv(2048))
            except BlockingIOError:
                return items


@pytest.fixture
def make_bench() -> Iterator[Callable[..., Bench]]:
    benches: list[Bench] = []

    def make(**options: Any) -> Bench:
        benches.append(Bench(**options))
        return benches[-1]

    yield make
    for bench in benches:
        bench.close()


def test_real_time_keeps_pace_with_the_wall_clock(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(speed_factor=2.0)
    bench.stop_at(SECOND_US // 5)
    real_wait = bench.server._selector.select

    def select(timeout_s: float | None = None) -> Any:
        bench.clock.now_s += timeout_s or 0.0  # the wait that the loop asks for
        return real_wait(0.0)

    bench.server._selector.select = select  # type: ignore[method-assign]
    bench.server.run()
    assert bench.clock.now_s == pytest.approx(0.1, abs=0.02)


def test_as_fast_as_possible_does_not_wait(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench()
    bench.stop_at(SECOND_US)
    bench.server.run()
    assert bench.simulation.time_us == SECOND_US


def test_telemetry_and_trigger_leave_before_the_image(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench()
    order: list[str] = []
    publish = bench.stream.publish

    def note(image: Frame) -> None:
        order.extend(message.get_type() for message in bench.received())
        order.append(f"image {image.time_us}")
        publish(image)

    bench.stream.publish = note  # type: ignore[method-assign]
    bench.stop_at(60_000)
    bench.server.run()
    for time_us in (0, 52_000):
        place = order.index(f"image {time_us}")
        assert order[place - 1] == "CAMERA_TRIGGER"
        assert "ATTITUDE" in order[:place]
    between = order[order.index("image 0") : order.index("image 52000")]
    assert between.count("ATTITUDE") == 5  # 100 Hz: the ticks at 12, 20, 32, 40 and 52 ms


def test_lockstep_stands_at_0_and_repeats_heartbeats(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True)
    stand, passes = bench.server._stand, 0

    def hurried_stand() -> None:
        nonlocal passes
        passes += 1
        bench.clock.now_s += 0.5
        if passes == 9:
            bench.server.stop()
        stand()

    bench.server._stand = hurried_stand  # type: ignore[method-assign]
    real_wait = bench.server._selector.select
    bench.server._selector.select = lambda _=None: real_wait(0.0)  # type: ignore[method-assign]
    bench.server.run()
    assert bench.simulation.time_us == 0
    heartbeat = mavlink.MAVLINK_MSG_ID_HEARTBEAT
    beats = [item.component for item in bench.arrived() if item.message_id == heartbeat]
    assert beats == [1, 100, 25] * (len(beats) // 3)
    assert 4 <= len(beats) // 3 <= 6


def test_lockstep_reads_nothing_between_an_answer_and_the_next_frame(
    make_bench: Callable[..., Bench],
) -> None:
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled: list[tuple[int, int]] = []
    command = bench.simulation.autopilot.command

    def note(asked: Any) -> Any:
        handled.append((bench.simulation.time_us, asked.command))
        return command(asked)

    bench.simulation.autopilot.command = note  # type: ignore[method-assign]
    publish = bench.stream.publish

    def look(image: Frame) -> None:
        publish(image)
        companion.send(
            mavlink.MAVLink_command_long_message(1, 1, 1000 + image.sequence, 0, *[0.0] * 7)
        )
        companion.answer(image.time_us)
        companion.send(
            mavlink.MAVLink_command_long_message(1, 1, 2000 + image.sequence, 0, *[0.0] * 7)
        )

    bench.stream.publish = look  # type: ignore[method-assign]
    bench.stop_at(200_000)
    bench.server.run()
    companion.tcp.close()
    # A command before the answer is handled at its frame, one after it only at the next.
    assert handled[:5] == [(0, 1000), (52_000, 2000), (52_000, 1001), (100_000, 2001),
                           (100_000, 1002)]  # fmt: skip


def test_lockstep_can_be_stopped_where_no_frame_comes(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    companion.answer(0)
    bench.simulation.frame_due = lambda: False  # type: ignore[method-assign]
    bench.stop_at(512_000)
    bench.server.run()
    assert bench.simulation.time_us == 512_000
    companion.tcp.close()


@pytest.mark.parametrize("speed_factor", [0.0, 1000.0])
def test_lockstep_listens_where_frames_stay_out(
    make_bench: Callable[..., Bench], speed_factor: float
) -> None:
    """A camera that fails must not make the vehicle deaf: it could never be told to land."""
    bench = make_bench(lockstep=True, speed_factor=speed_factor)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled: list[int] = []
    command = bench.simulation.autopilot.command

    def note(asked: Any) -> Any:
        handled.append(bench.simulation.time_us)
        return command(asked)

    bench.simulation.autopilot.command = note  # type: ignore[method-assign]
    companion.answer(0)
    companion.send(mavlink.MAVLink_command_long_message(1, 1, 1000, 0, *[0.0] * 7))
    bench.simulation.frame_due = lambda: bench.simulation.time_us == 0  # type: ignore[method-assign]
    bench.stop_at(2 * SECOND_US)
    bench.server.run()
    companion.tcp.close()
    assert len(handled) == 1
    assert 1.5 * SECOND_US < handled[0] < 1.7 * SECOND_US


def test_lockstep_reads_nothing_while_frames_stay_out_for_a_moment(
    make_bench: Callable[..., Bench],
) -> None:
    """A camera that fails intermittently is gone for a second, and a frame's time about it."""
    bench = make_bench(lockstep=True)
    companion = Companion(bench.stream, bench.link, bench.udp)
    handled: list[int] = []
    command = bench.simulation.autopilot.command

    def note(asked: Any) -> Any:
        handled.append(bench.simulation.time_us)
        return command(asked)

    bench.simulation.autopilot.command = note  # type: ignore[method-assign]
    companion.answer(0)
    companion.send(mavlink.MAVLink_command_long_message(1, 1, 1000, 0, *[0.0] * 7))
    due = iter((0, 1_052_000))
    next_us = next(due)

    def frame_due() -> bool:
        nonlocal next_us
        is_due = bench.simulation.time_us == next_us
        next_us = next(due, next_us) if is_due else next_us
        return is_due

    bench.simulation.frame_due = frame_due  # type: ignore[method-assign]
    stand = bench.server._stand

    def last_stand() -> None:
        stand()
        if handled:
            bench.server.stop()

    bench.server._stand = last_stand  # type: ignore[method-assign]
    bench.server.run()
    companion.tcp.close()
    assert handled == [1_052_000]


def test_lockstep_runs_free_when_the_viewer_leaves(make_bench: Callable[..., Bench]) -> None:
    bench = make_bench(lockstep=True, speed_factor=1000.0)
    companion = Companion(bench.stream, bench.link, bench.udp)
    publish = bench.stream.publish

    def look(image: Frame) -> None:
        publish(image)
        if image.sequence < 3:
            companion.answer(image.time_us)
        elif image.sequence == 3:
            companion.tcp.close()

    bench.stream.publish = look  # type: ignore[method-assign]
    bench.stop_at(SECOND_US)
    bench.server.run()
    assert bench.simulation.time_us == SECOND_US
