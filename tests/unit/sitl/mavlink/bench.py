"""The endpoint behind real loopback sockets, and clients at its links."""

import socket
from collections.abc import Iterable, Iterator
from typing import Any

from sitl.clock import TICK_US
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Guard
from sitl.mavlink.links.udp_link import LinkConfig, UdpLink
from sitl.mavlink.wire.packets import Received, pack, split, wrap
from tests.unit.sitl.mavlink.fakes import FakeVehicle

FACTS = CameraFacts(
    stream_uri="http://127.0.0.1:1/stream",
    width_px=64,
    height_px=64,
    field_of_view_deg=90,
    rate_hz=20.0,
)
EPOCH_US = 1_700_000_000_000_000


class Peer:
    """A socket at the other end of a link."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.0)
        self.port: int = self.socket.getsockname()[1]
        self.link: UdpLink

    def send_raw(self, raw: bytes) -> None:
        self.socket.sendto(raw, ("127.0.0.1", self.link.local_port))

    def datagrams(self) -> Iterator[bytes]:
        """Give what has come."""
        while True:
            try:
                yield self.socket.recv(4096)
            except BlockingIOError:
                return


class Client(Peer):
    """Somebody who speaks in packets of our own making."""

    def send(self, message: Any, system: int = 255, component: int = 190) -> bytes:
        raw = wrap(pack(message), sequence=0, system=system, component=component)
        self.send_raw(raw)
        return raw

    def take(self) -> list[Received]:
        return [item for datagram in self.datagrams() for item in split(datagram)]


def link_to(peer: Peer, index: int, guard: Guard | None = None) -> UdpLink:
    """Make a link of a vehicle to a peer."""
    config = LinkConfig(name=str(index), local_port=0, remote_port=peer.port)
    peer.link = UdpLink(config, system=1, index=index, guard=guard)
    return peer.link


def handle(endpoint: Endpoint, links: Iterable[UdpLink]) -> None:
    """Let the endpoint take all that has come."""
    for link in links:
        while endpoint.receive(link):
            pass


class Bench:
    """A vehicle with both links, and a client at each."""

    def __init__(self) -> None:
        self.vehicle = FakeVehicle()
        self.gcs, self.api = Client(), Client()
        self.links = [link_to(self.gcs, 0), link_to(self.api, 1)]
        self.endpoint = Endpoint(
            self.vehicle, self.links, system=1, camera=FACTS, unix_epoch_us=EPOCH_US
        )

    def close(self) -> None:
        for client in (self.gcs, self.api):
            client.link.close()
            client.socket.close()

    def handle(self) -> None:
        handle(self.endpoint, self.links)

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.endpoint.publish()
            self.vehicle.time_us += TICK_US
