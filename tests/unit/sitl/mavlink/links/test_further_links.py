"""Further links: over UDP to an address that was named, and over TCP."""

import socket
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.errors import LinkError
from sitl.mavlink.links.link import Guard
from sitl.mavlink.links.tcp_link import MAX_PENDING_BYTES, TcpLink
from sitl.mavlink.links.udp_client_link import UdpClientLink
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Received, pack, split, split_stream, wrap
from sitl.mavlink.wire.refusals import Refusal

HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
HOST = "127.0.0.1"


def raw(sequence: int = 0, system: int = 255) -> bytes:
    return wrap(pack(HEARTBEAT), sequence=sequence, system=system, component=190)


def drain(link: TcpLink | UdpClientLink) -> list[Received]:
    received: list[Received] = []
    while (messages := link.receive()) is not None:
        received += messages
    return received


@pytest.fixture
def guard() -> Guard:
    return Guard()


@pytest.fixture
def peer() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind((HOST, 0))
        peer.settimeout(1.0)
        yield peer


@pytest.fixture
def udp(peer: socket.socket, guard: Guard) -> Iterator[UdpClientLink]:
    link = UdpClientLink(peer.getsockname(), system=1, index=2, guard=guard)
    yield link
    link.close()


@pytest.fixture
def tcp(guard: Guard) -> Iterator[TcpLink]:
    link = TcpLink((HOST, 0), system=1, index=3, guard=guard)
    yield link
    link.close()


@pytest.fixture
def client(tcp: TcpLink) -> Iterator[socket.socket]:
    with socket.create_connection((HOST, tcp.local_port)) as client:
        client.settimeout(1.0)
        while not tcp.is_open:
            tcp.receive()
        yield client


def test_udp_goes_where_it_was_told_and_hears_only_from_there(
    udp: UdpClientLink, peer: socket.socket, guard: Guard
) -> None:
    udp.send(HEARTBEAT)
    data, address = peer.recvfrom(2048)
    assert [(r.system, r.component) for r in split(data)] == [(1, 1)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(raw(system=66), address)
    peer.sendto(b"nonsense", address)
    peer.sendto(raw(), address)
    assert [r.system for r in drain(udp)] == [255]
    assert guard.refusals.totals == {Refusal.NO_PACKET: 1}


def test_udp_to_nobody_waits_for_somebody(udp: UdpClientLink, peer: socket.socket) -> None:
    address = peer.getsockname()
    peer.close()
    for _ in range(3):
        udp.send(HEARTBEAT)
        drain(udp)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as later:
        later.bind(address)
        later.settimeout(1.0)
        udp.send(HEARTBEAT)
        udp.send(HEARTBEAT)  # the first may only fetch the error of the last
        assert split(later.recv(2048))


@pytest.mark.parametrize(
    ("host", "says"),
    [(HOST, "link 2 udp to 127.0.0.1:9"), ("192.0.2.1", "who sends from there commands")],
)
def test_udp_says_what_it_opens(host: str, says: str) -> None:
    try:
        link = UdpClientLink((host, 9), system=1, index=2)
    except LinkError:
        pytest.skip("this machine has no network")
    assert says in link.describe()
    link.close()


def test_an_unknown_host_is_one_line() -> None:
    with pytest.raises(LinkError, match=r"--udp no\.such\.host\.invalid:9"):
        UdpClientLink(("no.such.host.invalid", 9), system=1, index=2)


def test_tcp_carries_packets_both_ways(tcp: TcpLink, client: socket.socket) -> None:
    tcp.send(HEARTBEAT)
    assert len(split(client.recv(4096))) == 1
    for piece in (raw(0)[:5], raw(0)[5:] + raw(1) + b"junk", raw(2)[:-1], raw(2)[-1:]):
        client.sendall(piece)
    received: list[Received] = []
    while len(received) < 3:
        received += drain(tcp)
    assert [r.raw[4] for r in received] == [0, 1, 2]


def test_tcp_has_one_client_at_a_time(tcp: TcpLink, client: socket.socket) -> None:
    with socket.create_connection((HOST, tcp.local_port)) as second:
        second.settimeout(1.0)
        drain(tcp)
        assert second.recv(10) == b""
    tcp.gcs_heard = True
    client.close()
    while tcp.is_open:
        tcp.receive()
    assert not tcp.gcs_heard
    tcp.send(HEARTBEAT)  # to nobody
    with socket.create_connection((HOST, tcp.local_port)):
        while not tcp.is_open:
            tcp.receive()


def test_a_slow_tcp_client_loses_whole_packets_only(tcp: TcpLink, client: socket.socket) -> None:
    for _ in range(200_000):
        tcp.send(HEARTBEAT)
    assert len(tcp._pending) <= MAX_PENDING_BYTES
    client.settimeout(0.2)
    data = b""
    while True:
        drain(tcp)
        try:
            data += client.recv(1 << 20)
        except TimeoutError:
            break
    received, rest = split_stream(data)
    assert rest == b""
    assert sum(len(r.raw) for r in received) == len(data)


def test_tcp_noise_is_counted(tcp: TcpLink, client: socket.socket, guard: Guard) -> None:
    client.sendall(b"GET / HTTP/1.1\r\n\r\n" * 10)
    while not guard.refusals.totals:
        assert drain(tcp) == []
    assert guard.refusals.totals == {Refusal.NO_PACKET: 1}


def test_tcp_says_what_it_opens() -> None:
    link = TcpLink(("0.0.0.0", 0), system=1, index=2)  # noqa: S104  asked for
    assert "open to the network" in link.describe()
    with pytest.raises(LinkError, match="is in use"):
        TcpLink((HOST, link.local_port), system=1, index=3)
    link.close()


@given(
    st.lists(
        st.integers(0, 255) | st.binary(max_size=12).filter(lambda b: not set(b) & {253, 254})
    ),
    st.data(),
)
def test_a_stream_cut_anywhere_gives_the_same_packets(
    items: list[int | bytes], data: st.DataObject
) -> None:
    stream = b"".join(item if isinstance(item, bytes) else raw(item) for item in items)
    sequences = [item for item in items if isinstance(item, int)]
    got: list[int] = []
    rest = b""
    while stream:
        cut = data.draw(st.integers(1, len(stream)))
        received, rest = split_stream(rest + stream[:cut])
        got += [r.raw[4] for r in received]
        stream = stream[cut:]
    assert got == sequences


def test_what_was_gathered_for_a_client_is_not_for_the_next(tcp: TcpLink) -> None:
    tcp.gather()
    with socket.create_connection((HOST, tcp.local_port)) as first:
        first.sendall(raw())
        while not drain(tcp):
            pass
        tcp.send(HEARTBEAT)
    while tcp.is_open:
        drain(tcp)
    with socket.create_connection((HOST, tcp.local_port)) as second:
        while not tcp.is_open:
            drain(tcp)
        tcp.send(HEARTBEAT)
        tcp.flush()
        second.settimeout(1.0)
        (received,) = split(second.recv(2048))
        assert received.raw[4] == 1  # the first one's message, number 0, went with it
