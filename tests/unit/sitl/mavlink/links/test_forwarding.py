import socket
from collections.abc import Iterator

import pytest

from sitl.mavlink.links.forwarding import MAX_COMPONENTS, Forwarder
from sitl.mavlink.links.udp_link import LinkConfig, UdpLink
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, split, wrap

PING = mavlink.MAVLink_ping_message(1, 1, 0, 0)


class Pair:
    """Two links, and the socket behind the second."""

    def __init__(self) -> None:
        self.far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.far.bind(("127.0.0.1", 0))
        self.far.settimeout(0.0)
        ports = (9, self.far.getsockname()[1])
        self.links = [
            UdpLink(LinkConfig(name="link", local_port=0, remote_port=port), system=1, index=index)
            for index, port in enumerate(ports)
        ]
        self.forwarder = Forwarder(self.links, system=1)

    def close(self) -> None:
        self.far.close()
        for link in self.links:
            link.close()

    def pass_on(self, message: object, system: int, component: int, source: int = 0) -> bool:
        """Say whether the message reached the second link."""
        raw = wrap(pack(message), sequence=0, system=system, component=component)
        (received,) = split(raw)
        self.forwarder.forward(received, self.links[source])
        try:
            assert self.far.recv(2048) == raw
        except BlockingIOError:
            return False
        return True


@pytest.fixture
def pair() -> Iterator[Pair]:
    pair = Pair()
    yield pair
    pair.close()


def test_what_is_for_everybody_goes_on_but_not_back(pair: Pair) -> None:
    assert pair.pass_on(PING, 255, 190)
    assert not pair.pass_on(PING, 255, 190, source=1)


def test_a_key_never_leaves_its_link(pair: Pair) -> None:
    key = mavlink.MAVLink_setup_signing_message(0, 0, [1] * 32, 1)
    assert not pair.pass_on(key, 255, 190)


def test_the_table_of_components_is_bounded_on_each_link_apart(pair: Pair) -> None:
    pair.pass_on(PING, 7, 7, source=1)
    for number in range(4 * MAX_COMPONENTS):
        pair.pass_on(PING, 10 + number // 200, 1 + number % 200)
    assert len(pair.forwarder._seen[pair.links[0]]) == MAX_COMPONENTS
    question = mavlink.MAVLink_command_long_message(7, 7, 512, 0, *[0.0] * 7)
    assert pair.pass_on(question, 255, 190)
