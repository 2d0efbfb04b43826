import socket
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sitl.hil.relay import CompanionLink, Px4Side, relay_ports
from sitl.mavlink.links.link import Guard
from sitl.mavlink.links.udp_link import LinkConfig
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, wrap


class Relay:
    """A relay between two sockets of ours."""

    def __init__(self) -> None:
        self.px4, self.companion = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in "12")
        for end in (self.px4, self.companion):
            end.bind(("127.0.0.1", 0))
            end.settimeout(1.0)
        ports = LinkConfig(name="px4", local_port=0, remote_port=self.px4.getsockname()[1])
        self.px4_side = Px4Side(ports)
        config = LinkConfig(name="relay", local_port=0, remote_port=self.companion.getsockname()[1])
        self.link = CompanionLink(config, self.px4_side, system=1, index=1, guard=Guard())
        self.px4_side.link = self.link

    def close(self) -> None:
        for end in (self.px4, self.companion, self.px4_side, self.link):
            end.close()

    def from_px4(self, datagram: bytes) -> bytes:
        self.px4.sendto(datagram, ("127.0.0.1", self.px4_side.local_port))
        self.px4_side.serve(1.0)
        return self.companion.recv(4096)

    def from_companion(self, datagram: bytes) -> bytes:
        self.companion.sendto(datagram, ("127.0.0.1", self.link.local_port))
        while self.link.receive() is None:
            pass
        return self.px4.recv(4096)


@pytest.fixture
def relay() -> Iterator[Relay]:
    relay = Relay()
    yield relay
    relay.close()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)
@given(st.binary(min_size=1, max_size=300))
def test_every_byte_passes_either_way(relay: Relay, datagram: bytes) -> None:
    assert relay.from_px4(datagram) == datagram
    assert relay.from_companion(datagram) == datagram


def test_the_time_of_the_newest_attitude_is_known(relay: Relay) -> None:
    heartbeat = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3)
    attitude = mavlink.MAVLink_attitude_message(7616, *[0.0] * 6)
    packets = [wrap(pack(m), sequence=0, system=1, component=1) for m in (heartbeat, attitude)]
    relay.from_px4(packets[0])
    assert relay.px4_side.attitude_us == -1
    relay.from_px4(b"".join(packets))
    assert relay.px4_side.attitude_us == 7_616_000
    relay.px4_side.forget()
    assert relay.px4_side.attitude_us == -1


def test_the_ports_are_those_that_px4_gives_an_instance() -> None:
    ends = [(ports.local_port, ports.remote_port) for ports in map(relay_ports, (0, 3, 12))]
    assert ends == [(14540, 14580), (14543, 14583), (14549, 14592)]
