"""A further link over TCP: wait on a port for a client, and serve one at a time.

Packets are cut out of the stream as they come. A client that reads too slowly loses whole packets;
it never holds up the vehicle.
"""

import errno
import selectors
import socket

from sitl.errors import LinkError
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.links.udp_link import Address
from sitl.mavlink.wire.packets import Received, split_stream
from sitl.mavlink.wire.refusals import Refusal

RECEIVE_BYTES = 4096
MAX_PENDING_BYTES = 1 << 18  # what a slow client may be behind


class TcpLink(Link):
    """A non-blocking TCP server for one client; has a selector of its own, to be nested."""

    def __init__(
        self, local: Address, *, system: int, index: int, guard: Guard | None = None
    ) -> None:
        """Listen.

        Raises:
            LinkError: the port cannot be had.

        """
        super().__init__(f"link {index}", system=system, index=index, guard=guard)
        self._listener = _listen(local)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._client: socket.socket | None = None
        self._unread = b""
        self._pending = bytearray()

    def close(self) -> None:
        """Free the port."""
        self._drop()
        self._selector.close()
        self._listener.close()

    def fileno(self) -> int:
        """For a selector."""
        return self._selector.fileno()

    @property
    def local_port(self) -> int:
        """The bound port."""
        return int(self._listener.getsockname()[1])

    def describe(self) -> str:
        """Name the port, and who can reach it."""
        host = self._listener.getsockname()[0]
        if host.startswith("127."):
            return f"{self.name} tcp {self.local_port}"
        return (
            f"{self.name} tcp {host}:{self.local_port}: open to the network, "
            "who reaches it commands the vehicle"
        )

    @property
    def is_open(self) -> bool:
        """Whether there is a client."""
        return self._client is not None

    def _transmit(self, data: bytes) -> None:
        if self._client is None or len(self._pending) + len(data) > MAX_PENDING_BYTES:
            return
        self._pending += data
        self._flush()

    def _take(self) -> list[Received] | None:
        """Serve whatever the selector says; None once nothing more is to be done."""
        for key, events in self._selector.select(0.0):
            if key.fileobj is self._listener:
                self._accept()
                return []
            if events & selectors.EVENT_WRITE:
                self._flush()
            if events & selectors.EVENT_READ:
                return self._read()
        return None

    def _adopt_sender(self) -> None:
        """Nothing to do: there is only one."""

    def _accept(self) -> None:
        try:
            client, _ = self._listener.accept()
        except OSError:
            return  # it went away before we looked
        if self._client is not None:
            client.close()
            return
        client.settimeout(0.0)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        self._forget()
        self._client = client
        self._selector.register(client, selectors.EVENT_READ)

    def _read(self) -> list[Received]:
        if self._client is None:
            return []
        try:
            data = self._client.recv(RECEIVE_BYTES)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data:
            self._drop()
            return []
        messages, self._unread = split_stream(self._unread + data)
        if not messages and not self._unread:
            self._guard.refusals.note([Refusal.NO_PACKET])
        return messages

    def _flush(self) -> None:
        if self._client is None:
            return
        events = selectors.EVENT_READ
        try:
            while self._pending:
                del self._pending[: self._client.send(self._pending)]
        except BlockingIOError:
            events |= selectors.EVENT_WRITE
        except OSError:
            self._drop()
            return
        if self._selector.get_key(self._client).events != events:
            self._selector.modify(self._client, events)

    def _drop(self) -> None:
        if self._client is not None:
            self._selector.unregister(self._client)
            self._client.close()
        self._client = None
        self._unread = b""
        self._pending.clear()
        self._forget()


def _listen(local: Address) -> socket.socket:
    host, port = local
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.settimeout(0.0)
    try:
        listener.bind(local)
        listener.listen(1)
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        if error.errno == errno.EADDRINUSE:
            reason = "is in use; choose another port"
        raise LinkError(f"--tcp {host}:{port}: {reason}") from None
    return listener
