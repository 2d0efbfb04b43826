import socket
from collections.abc import Callable

import pytest

from sitl.errors import LinkError
from sitl.mavlink.links.link import MAX_DATAGRAM_BYTES
from sitl.mavlink.links.udp_link import LinkConfig, UdpLink
from sitl.mavlink.wire.dialect import CAMERA, mavlink
from sitl.mavlink.wire.packets import pack, split, wrap

HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
VALID = wrap(pack(HEARTBEAT), sequence=0, system=255, component=190)


class Peer:
    """A client's socket."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(2.0)
        self.port: int = self.socket.getsockname()[1]

    def __enter__(self) -> "Peer":
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def send(self, data: bytes, link: UdpLink) -> None:
        self.socket.sendto(data, ("127.0.0.1", link.local_port))

    def receive(self) -> bytes:
        return self.socket.recv(2048)

    def has_nothing(self) -> bool:
        self.socket.settimeout(0.0)
        try:
            self.socket.recv(2048)
        except BlockingIOError:
            return True
        return False


def make_link(remote_port: int) -> UdpLink:
    return UdpLink(LinkConfig(name="gcs", local_port=0, remote_port=remote_port), system=3)


def test_sends_unprompted_until_the_first_valid_packet_names_the_partner() -> None:
    with Peer() as default, Peer() as first, Peer() as later:
        link = make_link(default.port)
        link.send(HEARTBEAT)
        assert split(default.receive())[0].system == 3
        first.send(b"not a packet", link)
        assert link.receive() == []
        assert link.remote == ("127.0.0.1", default.port)
        first.send(VALID, link)
        later.send(VALID, link)
        assert [len(link.receive() or []) for _ in range(2)] == [1, 1]
        assert link.receive() is None
        link.send(HEARTBEAT)
        assert split(first.receive())
        assert later.has_nothing()
        assert default.has_nothing()
        link.close()


def test_what_is_gathered_leaves_in_order_in_few_datagrams() -> None:
    with Peer() as peer:
        link = make_link(peer.port)
        link.gather()
        for _ in range(100):
            link.send(HEARTBEAT)
        link.send_together([pack(HEARTBEAT)] * 20)
        link.flush()
        link.flush()
        datagrams = [peer.receive(), peer.receive()]
        assert peer.has_nothing()
        assert all(len(datagram) <= MAX_DATAGRAM_BYTES for datagram in datagrams)
        numbers = [item.raw[4] for datagram in datagrams for item in split(datagram)]
        assert numbers == list(range(120))
        link.close()


def test_a_bad_radio_carries_each_message_by_itself_after_what_was_gathered() -> None:
    class Radio:
        def carry(self, data: bytes, transmit: Callable[[bytes], None]) -> None:
            transmit(data)

    with Peer() as peer:
        link = make_link(peer.port)
        link.gather()
        link.send(HEARTBEAT)
        link.radio = Radio()
        link.send(HEARTBEAT)
        link.send(HEARTBEAT)
        assert [split(peer.receive())[0].raw[4] for _ in range(3)] == [0, 1, 2]
        link.close()


def test_each_component_counts_its_own_sequence() -> None:
    with Peer() as peer:
        link = make_link(peer.port)
        for component in (1, CAMERA, 1, 1):
            link.send(HEARTBEAT, component)
        received = [split(peer.receive())[0] for _ in range(4)]
        counted = [(item.component, item.raw[4]) for item in received]
        assert counted == [(1, 0), (CAMERA, 0), (1, 1), (1, 2)]
        link.close()


def test_sequence_wraps_without_a_gap() -> None:
    with Peer() as peer:
        link = make_link(peer.port)
        numbers = []
        for _ in range(258):
            link.send(HEARTBEAT)
            numbers.append(split(peer.receive())[0].raw[4])
        assert numbers[254:] == [254, 255, 0, 1]
        link.close()


def test_a_tap_sees_both_directions() -> None:
    class Tap:
        def __init__(self) -> None:
            self.packets: list[tuple[int, bytes]] = []

        def record(self, *packets: bytes, link: int) -> None:
            self.packets += [(link, raw) for raw in packets]

    with Peer() as peer:
        config = LinkConfig(name="api", local_port=0, remote_port=peer.port)
        link = UdpLink(config, system=1, index=1)
        tap = Tap()
        link.add_tap(tap)
        peer.send(VALID + b"junk", link)
        link.receive()
        link.send(HEARTBEAT)
        assert tap.packets == [(1, VALID), (1, peer.receive())]
        link.close()


def test_a_busy_port_is_refused_with_the_remedy() -> None:
    with Peer() as peer:
        config = LinkConfig(name="gcs", local_port=peer.port, remote_port=9)
        with pytest.raises(LinkError, match=f"{peer.port} is in use.*--instance"):
            UdpLink(config, system=1)
