"""Carry bytes to and from a vehicle: over UDP, TCP or a serial line; nothing here ever blocks.

A transport that breaks in flight does not raise: what cannot be sent is lost, as on any radio, and
the link's silence tells. Opening one raises LinkError with the reason.
"""

import contextlib
import errno
import os
import select
import socket
from typing import Protocol

from flightstack.errors import LinkError
from flightstack.libraries import load_library
from flightstack.mavlink.endpoint import Endpoint, Kind
from flightstack.mavlink.packets import PacketSplitter, split_packets

CONNECT_TIMEOUT_S = 5.0
DATAGRAM_BYTES = 65535
RECEIVE_BUFFER_BYTES = 1 << 20  # bridges the seconds in which a model is being loaded
MAX_DATAGRAMS = 4096  # at once: whoever floods us does not keep us from what else there is to do
MAX_UNSOUND = 64  # beginnings of packets that were none, in one datagram
MAX_READS = 64  # at once, of a stream; a terminal gives 4 KiB a read
UNSENT_BYTES = 4096  # five answers to an image: more would reach a slow peer too late to be of use

Address = tuple[str, int]
Received = tuple[list[bytes], Address | None]  # packets of one read, and who sent them


class Transport(Protocol):
    """A way to the vehicle, ready for a selector."""

    closed: bool  # the other end has gone for good

    def fileno(self) -> int:
        """Return what a selector waits on."""

    def receive(self) -> list[Received]:
        """Return all that has arrived."""

    def forget_backlog(self) -> None:
        """Drop what has come while nobody read, where it may have holes."""

    def listen_only_to(self, partner: Address | None) -> None:
        """Drop what others send, where there are others; None listens to all again."""

    def send(self, packets: bytes, address: Address | None) -> bool:
        """Send whole packets, to `address` where we listen; False where there is nobody yet."""

    def close(self) -> None:
        """Let go of the socket or device."""


def open_transport(endpoint: Endpoint) -> Transport:
    """Open what a connection string names."""
    if endpoint.kind is Kind.UDP_LISTEN or endpoint.kind is Kind.UDP_SEND:
        return UdpTransport(endpoint)
    if endpoint.kind is Kind.TCP:
        return _connect_tcp(endpoint)
    return _open_serial(endpoint)


class UdpTransport:
    """Datagrams, each holding whole packets; one socket that listens, or that sends first."""

    def __init__(self, endpoint: Endpoint) -> None:
        self.closed = False
        self._peer: Address | None = None  # who was named
        self._partner: Address | None = None  # who alone is heard
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._open(endpoint)
        except OSError as error:
            self._socket.close()
            raise LinkError(_explain(endpoint, error)) from error
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        self._socket.settimeout(0.0)

    def _open(self, endpoint: Endpoint) -> None:
        if endpoint.kind is Kind.UDP_LISTEN:
            self._socket.bind((endpoint.host, endpoint.port))
        else:
            self._peer = (socket.gethostbyname(endpoint.host), endpoint.port)

    @property
    def address(self) -> Address:
        """Our own end."""
        host, port = self._socket.getsockname()
        return (host, port)

    def fileno(self) -> int:
        """Return what a selector waits on."""
        return self._socket.fileno()

    def receive(self) -> list[Received]:
        """Return the datagrams that have arrived, cut into packets; of strangers, nothing."""
        received: list[Received] = []
        for _ in range(MAX_DATAGRAMS):
            try:
                datagram, address = self._socket.recvfrom(DATAGRAM_BYTES)
            except OSError:  # nothing more, or an earlier datagram came back as unreachable
                break
            if self._partner is None or address == self._partner:
                received.append((split_packets(datagram, MAX_UNSOUND)[0], address))
        return received

    def listen_only_to(self, partner: Address | None) -> None:
        """Drop what others send, unread; None listens to all again."""
        self._partner = partner

    def forget_backlog(self) -> None:
        """Keep all: the receive buffer holds what a vehicle says in half a minute."""

    def send(self, packets: bytes, address: Address | None) -> bool:
        """Send one datagram to the vehicle that has been heard, or to the one that was named."""
        target = address or self._peer
        if target is None:
            return False
        with contextlib.suppress(OSError):  # lost, as datagrams are
            self._socket.sendto(packets, target)
        return True

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()


class Opened(Protocol):
    """A connected socket, or pyserial's Serial."""

    def fileno(self) -> int:
        """Return the open descriptor."""

    def close(self) -> None:
        """Close it."""


class StreamTransport:
    """A byte stream, from TCP or a serial line, through a non-blocking file descriptor."""

    def __init__(self, owner: Opened) -> None:
        self.closed = False
        self._owner = owner
        self._splitter = PacketSplitter()
        self._unsent = b""
        os.set_blocking(owner.fileno(), False)

    def fileno(self) -> int:
        """Return what a selector waits on."""
        return self._owner.fileno()

    def receive(self) -> list[Received]:
        """Return the packets that have arrived whole; all of them, as far as can be told."""
        packets: list[bytes] = []
        for _ in range(MAX_READS):
            # A serial line without data reads as empty, like one that is gone: ask first.
            if self.closed or not select.select([self], [], [], 0)[0]:
                break
            try:
                data = os.read(self._owner.fileno(), DATAGRAM_BYTES)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            self.closed = not data
            packets += self._splitter.split(data)
        return [(packets, None)] if packets else []

    def forget_backlog(self) -> None:
        """Drop all that waits: a serial line keeps the first of it, and then has lost the rest."""
        while self.receive():
            continue
        self._splitter = PacketSplitter()

    def listen_only_to(self, partner: Address | None) -> None:
        """Change nothing: a stream has one other end."""

    def send(self, packets: bytes, address: Address | None) -> bool:  # noqa: ARG002  (protocol)
        """Send whole packets; False where the other end has gone, or is too far behind."""
        self._flush()
        if self.closed or len(self._unsent) + len(packets) > UNSENT_BYTES:
            return False
        self._unsent += packets
        self._flush()
        return not self.closed

    def _flush(self) -> None:
        if not self._unsent:
            return
        try:
            written = os.write(self._owner.fileno(), self._unsent)
        except BlockingIOError:
            return
        except OSError:
            self.closed = True
        else:
            self._unsent = self._unsent[written:]

    def close(self) -> None:
        """Let go of the socket or device."""
        self._owner.close()


def _connect_tcp(endpoint: Endpoint) -> StreamTransport:
    try:
        connected = socket.create_connection((endpoint.host, endpoint.port), CONNECT_TIMEOUT_S)
    except OSError as error:
        raise LinkError(_explain(endpoint, error)) from error
    connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return StreamTransport(connected)


def _open_serial(endpoint: Endpoint) -> StreamTransport:
    serial = load_library("serial", "serial")
    try:
        return StreamTransport(serial.Serial(endpoint.host, endpoint.port, exclusive=True))
    except (OSError, ValueError) as error:  # SerialException is an OSError
        raise LinkError(_explain(endpoint, error)) from error


def _explain(endpoint: Endpoint, error: Exception) -> str:
    number = getattr(error, "errno", None) or 0
    if number == errno.EADDRINUSE:
        return f"port {endpoint.port} is in use by another program; choose another, such as 14540"
    reason = os.strerror(number) if number > 0 else getattr(error, "strerror", None) or str(error)
    return f"cannot open {endpoint}: {reason}"
