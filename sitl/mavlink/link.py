"""One MAVLink link over UDP: who it talks to, and its sequence numbers.

A link sends unprompted to its default remote, as PX4 does. The first sender of a valid frame
becomes its partner for good: later senders are obeyed, but the answers go to the partner.
"""

import errno
import socket
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from sitl.errors import LinkError
from sitl.mavlink.dialect import AUTOPILOT, Message
from sitl.mavlink.framing import Packet, Received, frame, pack, split

LOOPBACK = "127.0.0.1"
RECEIVE_BYTES = 2048  # a MAVLink frame has at most 280; longer datagrams are cut
RECEIVE_BUFFER_BYTES = 1 << 20
MAX_DATAGRAM_BYTES = 1400  # below any usual network's limit

Address = tuple[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkConfig:
    """Where a link listens and whom it greets."""

    name: str
    local_port: int  # 0: any free port
    remote_port: int


class Tap(Protocol):
    """Whoever keeps a copy of the traffic."""

    def record(self, raw: bytes, *, link: int) -> None:
        """Take one frame of link number `link`."""


class Link:
    """A non-blocking UDP socket that speaks MAVLink 2."""

    def __init__(self, config: LinkConfig, *, system: int, index: int = 0) -> None:
        """Bind the local port.

        Raises:
            LinkError: the port cannot be had.

        """
        self.name = config.name
        self.index = index
        self.gcs_heard = False  # a ground station's HEARTBEAT came in: it wants STATUSTEXT
        self.tap: Tap | None = None
        self._system = system
        self._remote: Address = (LOOPBACK, config.remote_port)
        self._has_partner = False
        self._sequences: dict[int, int] = {}
        self._texts = 0
        self._socket = _bind(config)

    def close(self) -> None:
        """Free the port."""
        self._socket.close()

    def fileno(self) -> int:
        """For a selector."""
        return self._socket.fileno()

    @property
    def local_port(self) -> int:
        """The bound port."""
        return int(self._socket.getsockname()[1])

    @property
    def remote(self) -> Address:
        """Where this link's messages go now."""
        return self._remote

    def send(self, message: Message, component: int = AUTOPILOT) -> None:
        """Send a message as one of the vehicle's components."""
        self.send_packet(pack(message), component)

    def send_packet(self, packet: Packet, component: int = AUTOPILOT) -> None:
        """Send a packed message as one of the vehicle's components."""
        self.send_raw(self._frame(packet, component))

    def send_together(self, packets: Iterable[Packet]) -> None:
        """Send the autopilot's packed messages in as few datagrams as hold them."""
        datagram = b""
        for packet in packets:
            raw = self._frame(packet, AUTOPILOT)
            if self.tap is not None:
                self.tap.record(raw, link=self.index)
            if len(datagram) + len(raw) > MAX_DATAGRAM_BYTES:
                self._send(datagram)
                datagram = b""
            datagram += raw
        if datagram:
            self._send(datagram)

    def send_raw(self, raw: bytes) -> None:
        """Send a whole frame as it is."""
        if self.tap is not None:
            self.tap.record(raw, link=self.index)
        self._send(raw)

    def _frame(self, packet: Packet, component: int) -> bytes:
        sequence = self._sequences.get(component, 0)
        self._sequences[component] = (sequence + 1) & 0xFF
        return frame(packet, sequence=sequence, system=self._system, component=component)

    def _send(self, datagram: bytes) -> None:
        """Send; a full or unreachable destination loses it, as UDP does."""
        with suppress(OSError):
            self._socket.sendto(datagram, self._remote)

    def next_text_id(self) -> int:
        """Give the number of this link's next text; PX4 counts them from 0."""
        number = self._texts
        self._texts = (number + 1) & 0xFFFF
        return number

    def receive(self) -> list[Received] | None:
        """Take one datagram: its messages, or None if nothing waits. Never raises."""
        try:
            datagram, sender = self._socket.recvfrom(RECEIVE_BYTES)
        except OSError:
            return None
        messages = split(datagram)
        if messages and not self._has_partner:
            self._remote, self._has_partner = sender, True
        if self.tap is not None:
            for received in messages:
                self.tap.record(received.raw, link=self.index)
        return messages


def _bind(config: LinkConfig) -> socket.socket:
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.settimeout(0.0)
    udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    try:
        udp.bind((LOOPBACK, config.local_port))
    except OSError as error:
        udp.close()
        if error.errno == errno.EADDRINUSE:
            raise LinkError(
                f"UDP port {config.local_port} is in use: another vehicle probably runs; "
                "choose another with --instance"
            ) from None
        raise LinkError(f"UDP port {config.local_port}: {error.strerror}") from None
    return udp
