"""What wakes the companion's loop: sockets stand in for the link and for the camera."""

import socket
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from flightstack.clock import VehicleClock
from flightstack.companion import loop
from flightstack.companion.loop import FlightLoop
from flightstack.companion.waiting import wait_for_any
from flightstack.errors import FlightstackError


class Source:
    """Something that a selector waits on, and that is read out whole."""

    def __init__(self) -> None:
        self.announced_hz: float | None = None
        self.fault: FlightstackError | None = None
        self._end, self._socket = socket.socketpair()
        self.clock = VehicleClock()

    def arrive(self) -> None:
        self._end.send(b"x")

    def read(self) -> None:
        self._socket.recv(100)

    def fileno(self) -> int:
        return self._socket.fileno()

    def close(self) -> None:
        self._end.close()
        self._socket.close()


class Sleeper:
    """A loop that only sleeps, and what it waited for."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.link, self.camera = Source(), Source()
        self.received = 0
        self.waits: list[tuple[Source, ...]] = []
        vehicle: Any = SimpleNamespace(link=self.link, receive=self._receive)
        nobody: Any = None
        self.loop = FlightLoop(vehicle, self.camera, nobody, nobody)  # type: ignore[arg-type]

        def wait(_: float, *sources: Source) -> bool:
            self.waits.append(sources)
            return wait_for_any(0.0, *sources)

        monkeypatch.setattr(loop, "wait_for_any", wait)

    def sleep(self, *, images_flow: bool) -> None:
        self.loop._images_flow = images_flow
        self.loop._sleep()

    def _receive(self) -> None:
        self.received += 1
        self.link.read()


@pytest.fixture
def sleeper(monkeypatch: pytest.MonkeyPatch) -> Iterator[Sleeper]:
    sleeper = Sleeper(monkeypatch)
    yield sleeper
    sleeper.link.close()
    sleeper.camera.close()


def test_telemetry_is_taken_in_before_the_image_that_it_belongs_to(sleeper: Sleeper) -> None:
    sleeper.link.arrive()
    sleeper.camera.arrive()
    sleeper.sleep(images_flow=True)
    assert sleeper.received == 1
    assert sleeper.waits == [(sleeper.link, sleeper.camera), (sleeper.camera,)]


def test_telemetry_does_not_end_the_wait_for_an_image(sleeper: Sleeper) -> None:
    sleeper.link.arrive()
    sleeper.sleep(images_flow=True)
    assert sleeper.received == 1
    assert (sleeper.camera,) in sleeper.waits
    assert len(sleeper.waits) == 3  # and then for either, as where no images come


def test_without_images_every_datagram_ends_the_sleep(sleeper: Sleeper) -> None:
    sleeper.link.arrive()
    sleeper.sleep(images_flow=False)
    assert sleeper.received == 0  # that is for the turn that follows
    assert sleeper.waits == [(sleeper.link, sleeper.camera)]
