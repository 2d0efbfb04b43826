"""A further link over UDP, out to one address that the user has named.

It is connected: the system drops what comes from anywhere else, so it opens nothing to others.
"""

import socket
from contextlib import suppress

from sitl.errors import LinkError
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.links.udp_link import RECEIVE_BUFFER_BYTES, RECEIVE_BYTES, Address
from sitl.mavlink.wire.packets import Received, split
from sitl.mavlink.wire.refusals import Refusal


class UdpClientLink(Link):
    """A non-blocking UDP socket that sends to one address and hears only it."""

    def __init__(
        self, remote: Address, *, system: int, index: int, guard: Guard | None = None
    ) -> None:
        """Take any free port.

        Raises:
            LinkError: there is no such host, or no way there.

        """
        super().__init__(f"link {index}", system=system, index=index, guard=guard)
        self._remote = remote
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(0.0)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        try:
            self._socket.connect(remote)
        except OSError as error:
            self._socket.close()
            raise LinkError(f"--udp {remote[0]}:{remote[1]}: {error.strerror or error}") from None

    def close(self) -> None:
        """Free the port."""
        self._socket.close()

    def fileno(self) -> int:
        """For a selector."""
        return self._socket.fileno()

    def describe(self) -> str:
        """Say where it goes, and who may command the vehicle by it."""
        host, port = self._remote
        peer: Address = self._socket.getpeername()
        if peer[0].startswith("127."):
            return f"{self.name} udp to {host}:{port}"
        return f"{self.name} udp to {host}:{port}: who sends from there commands the vehicle"

    def _transmit(self, data: bytes) -> None:
        with suppress(OSError):  # nobody there (yet), or no room: lost, as UDP does
            self._socket.send(data)

    def _take(self) -> list[Received] | None:
        try:
            datagram = self._socket.recv(RECEIVE_BYTES)
        except ConnectionRefusedError:
            return []  # the answer to something we sent: nobody there (yet)
        except OSError:
            return None
        messages = split(datagram)
        if not messages:
            self._guard.refusals.note([Refusal.NO_PACKET])
        return messages

    def _adopt_sender(self) -> None:
        """Nothing to do: there is only one."""
