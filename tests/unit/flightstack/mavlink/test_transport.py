"""Bytes over real sockets and a real pseudo-terminal."""

import contextlib
import os
import select
import socket
import tty

import pytest

from flightstack.errors import LinkError
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.mavlink.packets import PacketSplitter
from flightstack.mavlink.transport import UNSENT_BYTES, Transport, UdpTransport, open_transport
from tests.unit.flightstack.mavlink.test_packets import heartbeat

WAIT_S = 5.0
READ_BYTES = 4096  # that a terminal gives at once
TERMINAL_BYTES = 65536  # that the kernel keeps for a pseudo-terminal, at most


def received(transport: Transport) -> list[bytes]:
    assert select.select([transport], [], [], WAIT_S)[0]
    return [packet for packets, _ in transport.receive() for packet in packets]


def free_udp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


def test_udp_listens_and_answers() -> None:
    listening = UdpTransport(parse_endpoint(f"udpin:127.0.0.1:{free_udp_port()}"))
    sending = UdpTransport(parse_endpoint(f"udpout:127.0.0.1:{listening.address[1]}"))
    sending.send(heartbeat(1), None)
    assert select.select([listening], [], [], WAIT_S)[0]
    ((packets, address),) = listening.receive()
    assert packets == [heartbeat(1)]
    listening.send(heartbeat(2), address)
    assert received(sending) == [heartbeat(2)]
    listening.send(heartbeat(3), None)  # nobody has been heard: nowhere to send
    for transport in (listening, sending):
        transport.close()


def test_udp_to_nobody_is_lost_quietly() -> None:
    sending = UdpTransport(parse_endpoint(f"udpout:127.0.0.1:{free_udp_port()}"))
    for number in range(3):
        sending.send(heartbeat(number), None)
        assert sending.receive() == []
    sending.close()


def test_a_busy_port_is_named() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as holder:
        holder.bind(("127.0.0.1", 0))
        port = holder.getsockname()[1]
        with pytest.raises(LinkError, match=f"port {port} is in use"):
            open_transport(parse_endpoint(str(port)))


def test_tcp_carries_packets_cut_anywhere() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        transport = open_transport(parse_endpoint(f"tcp:127.0.0.1:{server.getsockname()[1]}"))
        peer, _ = server.accept()
        peer.sendall(heartbeat(1) + heartbeat(2)[:5])
        assert received(transport) == [heartbeat(1)]
        peer.sendall(heartbeat(2)[5:])
        assert received(transport) == [heartbeat(2)]
        transport.send(heartbeat(3), None)
        assert peer.recv(100) == heartbeat(3)
        peer.close()
        assert received(transport) == []
        assert transport.closed
        transport.close()


def test_tcp_to_nobody_is_an_error() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(LinkError, match="Connection refused"):
        open_transport(parse_endpoint(f"tcp:127.0.0.1:{port}"))


def test_a_serial_line_carries_packets() -> None:
    ours, theirs = os.openpty()
    tty.setraw(ours)
    transport = open_transport(parse_endpoint(f"{os.ttyname(theirs)},921600"))
    os.write(ours, heartbeat(1))
    assert received(transport) == [heartbeat(1)]
    transport.send(heartbeat(2), None)
    assert os.read(ours, 100) == heartbeat(2)
    transport.close()
    os.close(ours)
    os.close(theirs)


def test_a_serial_line_is_gone_when_its_other_end_is_not_when_nothing_comes() -> None:
    ours, theirs = os.openpty()
    tty.setraw(ours)
    transport = open_transport(parse_endpoint(os.ttyname(theirs)))
    assert transport.receive() == []
    assert not transport.closed
    os.write(ours, heartbeat(1))
    assert received(transport) == [heartbeat(1)]
    assert transport.receive() == []
    assert not transport.closed
    os.close(ours)
    os.close(theirs)
    assert received(transport) == []
    assert transport.closed
    transport.close()


def test_a_serial_line_forgets_what_waited_for_too_long() -> None:
    ours, theirs = os.openpty()
    tty.setraw(ours)
    transport = open_transport(parse_endpoint(os.ttyname(theirs)))
    os.write(ours, heartbeat(1) * 100 + heartbeat(2)[:10])
    assert select.select([transport], [], [], WAIT_S)[0]
    transport.forget_backlog()
    os.write(ours, heartbeat(3))
    assert received(transport) == [heartbeat(3)]
    transport.close()
    os.close(ours)
    os.close(theirs)


def test_a_serial_line_is_read_to_its_end() -> None:
    ours, theirs = os.openpty()
    tty.setraw(ours)
    os.set_blocking(ours, False)
    transport = open_transport(parse_endpoint(os.ttyname(theirs)))
    sent = 0
    with contextlib.suppress(BlockingIOError):
        while sent < 2000:
            os.write(ours, heartbeat(sent % 256))
            sent += 1
    found = received(transport)
    assert len(found) * len(heartbeat()) > 2 * READ_BYTES
    assert len(found) >= sent - 1  # the last one may have been cut
    transport.close()
    os.close(ours)
    os.close(theirs)


def test_a_slow_peer_misses_whole_packets_and_is_never_far_behind() -> None:
    ours, theirs = os.openpty()
    tty.setraw(ours)
    os.set_blocking(ours, False)
    transport = open_transport(parse_endpoint(os.ttyname(theirs)))
    heard, taken, arrived = PacketSplitter(), [], []
    for number in range(5000):
        packet = heartbeat(number % 256, component=number // 256)
        if transport.send(packet, None):
            taken.append(packet)
        if number % 50 == 49:  # it reads a tenth of what it is sent
            arrived += heard.split(os.read(ours, 5 * len(packet)))
    assert len(arrived) < len(taken) < 4000
    assert arrived == taken[: len(arrived)]
    assert sum(map(len, taken[len(arrived) :])) < TERMINAL_BYTES + UNSENT_BYTES
    transport.close()
    os.close(ours)
    os.close(theirs)


def test_a_serial_line_that_is_not_there_is_an_error() -> None:
    with pytest.raises(LinkError, match="No such file"):
        open_transport(parse_endpoint("/dev/nosuchtty,57600"))


def test_an_unknown_host_is_an_error() -> None:
    with pytest.raises(LinkError, match=r"cannot open udpout:no\.such\.invalid:1"):
        open_transport(parse_endpoint("udpout:no.such.invalid:1"))
