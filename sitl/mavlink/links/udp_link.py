"""A link over UDP.

It sends unprompted to its default remote, as PX4 does. The first sender of a valid packet becomes
its partner for good: later senders are obeyed, but the answers go to the partner. With a signing
key, only a signed packet makes a partner.
"""

import errno
import socket
from contextlib import suppress
from dataclasses import dataclass

from sitl.errors import LinkError
from sitl.mavlink.links.link import LOOPBACK, Guard, Link
from sitl.mavlink.wire.packets import Received, split
from sitl.mavlink.wire.refusals import Refusal

RECEIVE_BYTES = 2048  # a MAVLink packet has at most 280; longer datagrams are cut
RECEIVE_BUFFER_BYTES = 1 << 20

Address = tuple[str, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkConfig:
    """Where a link listens and whom it greets; on the loopback interface, unless told."""

    name: str
    local_port: int  # 0: any free port
    remote_port: int  # 0: whoever speaks first
    host: str = LOOPBACK  # the interface on which it listens


class UdpLink(Link):
    """A non-blocking UDP socket, on the loopback interface unless its configuration says more."""

    def __init__(
        self, config: LinkConfig, *, system: int, index: int = 0, guard: Guard | None = None
    ) -> None:
        """Bind the local port.

        Raises:
            LinkError: the port cannot be had.

        """
        super().__init__(config.name, system=system, index=index, guard=guard)
        self._remote: Address = (LOOPBACK, config.remote_port)
        self._sender = self._remote
        self._has_partner = False
        self._socket = bind(config)

    def close(self) -> None:
        """Free the port."""
        self._socket.close()

    def fileno(self) -> int:
        """For a selector."""
        return self._socket.fileno()

    def describe(self) -> str:
        """Name the ports."""
        remote = self._remote[1]
        return f"{self.name} udp {self.local_port}" + (f" to {remote}" if remote else "")

    @property
    def local_port(self) -> int:
        """The bound port."""
        return int(self._socket.getsockname()[1])

    @property
    def remote(self) -> Address:
        """Where this link's messages go now."""
        return self._remote

    def _transmit(self, data: bytes) -> None:
        """Send; a full or unreachable destination loses it, as UDP does."""
        with suppress(OSError):
            self._socket.sendto(data, self._remote)

    def _take(self) -> list[Received] | None:
        try:
            datagram, self._sender = self._socket.recvfrom(RECEIVE_BYTES)
        except OSError:
            return None
        return self._judge(datagram)

    def _judge(self, datagram: bytes) -> list[Received]:
        """Find the packets of a datagram."""
        messages = split(datagram)
        if not messages:
            self._guard.refusals.note([Refusal.NO_PACKET])
        return messages

    def _adopt_sender(self) -> None:
        if not self._has_partner:
            self._remote, self._has_partner = self._sender, True


def bind(config: LinkConfig) -> socket.socket:
    """Open a non-blocking socket; raises LinkError if it can't be."""
    udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    udp.settimeout(0.0)
    udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
    try:
        udp.bind((config.host, config.local_port))
    except OSError as error:
        udp.close()
        if error.errno == errno.EADDRINUSE:
            raise LinkError(
                f"UDP port {config.local_port} is in use: another vehicle probably runs; "
                "choose another with --instance"
            ) from None
        raise LinkError(f"UDP port {config.local_port}: {error.strerror}") from None
    return udp
