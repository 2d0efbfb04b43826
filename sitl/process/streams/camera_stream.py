"""Serve the camera as a stamped HTTP stream, without ever blocking the vehicle.

A new client gets the latest image at once. A client that cannot keep up skips images: what it
is being sent is finished, then it gets the newest.
"""

import errno
import selectors
import socket

from sitl.errors import LinkError
from sitl.process.options.values import LOOPBACK
from sitl.process.streams.http_stream import (
    MAX_REQUEST_BYTES,
    Coding,
    answer,
    is_complete,
    only_watches,
    part,
)
from sitl.records.images import Image

MAX_CLIENTS = 16
RECEIVE_BYTES = 4096


class _Client:
    """One connection and what is still to be sent to it."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.request = b""
        self.answered = False
        self.watches = False  # it only looks, and answers no image
        self.coding: Coding | None = None  # of the stream that it requested
        self.pending = memoryview(b"")
        self.sequence = -1  # of the last image that it was given


class CameraStream:
    """A non-blocking HTTP server on one port; has a selector of its own, which may be nested."""

    def __init__(self, port: int) -> None:
        """Listen on a port of the loopback interface; 0 for any free one.

        Raises:
            LinkError: the port cannot be had.

        """
        self._selector = selectors.DefaultSelector()
        self._listener = _listen(port)
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._clients: dict[socket.socket, _Client] = {}
        self._latest: Image | None = None
        self._parts: dict[str, bytes] = {}  # of the latest image, by coding
        self.has_viewers = False  # anybody is connected to a stream who may answer

    def close(self) -> None:
        """Close all connections and free the port."""
        for client in list(self._clients.values()):
            self._drop(client)
        self._selector.close()
        self._listener.close()

    @property
    def port(self) -> int:
        """The port it listens on."""
        return int(self._listener.getsockname()[1])

    @property
    def uri(self) -> str:
        """Where the lossless stream is."""
        return f"http://{LOOPBACK}:{self.port}/stream"

    def fileno(self) -> int:
        """Give what becomes readable when `serve` has something to do: the selector's own."""
        return self._selector.fileno()

    def publish(self, image: Image) -> None:
        """Give a new image to everybody who is ready for it."""
        self._latest = image
        self._parts.clear()
        for client in list(self._clients.values()):
            if client.coding is not None and not client.pending:
                self._flush(client)

    def serve(self, timeout_s: float = 0.0) -> None:
        """Accept, read requests, send what waits; wait at most `timeout_s` for something to do."""
        for key, events in self._selector.select(timeout_s):
            if key.fileobj is self._listener:
                self._accept()
                continue
            client: _Client = key.data
            if events & selectors.EVENT_READ:
                self._read(client)
            if events & selectors.EVENT_WRITE and client.connection in self._clients:
                self._flush(client)

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError:
            return  # it went away before we looked
        connection.settimeout(0.0)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if len(self._clients) >= MAX_CLIENTS:
            idle = (c for c in self._clients.values() if not c.answered)
            oldest = next(idle, None)
            if oldest is None:
                connection.close()
                return
            self._drop(oldest)
        client = _Client(connection)
        self._clients[connection] = client
        self._selector.register(connection, selectors.EVENT_READ, client)

    def _read(self, client: _Client) -> None:
        try:
            data = client.connection.recv(RECEIVE_BYTES)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._drop(client)
            return
        if client.answered:
            return  # nothing that follows a request matters
        client.request += data
        if is_complete(client.request):
            client.answered = True
            head, client.coding = answer(client.request)
            client.watches = only_watches(client.request)
            self._count_viewers()
            client.pending = memoryview(head)
            self._flush(client)
        elif len(client.request) > MAX_REQUEST_BYTES:
            self._drop(client)

    def _flush(self, client: _Client) -> None:
        """Send as much as the connection takes, the newest image last."""
        while True:
            if not client.pending:
                client.pending = memoryview(self._next_part(client))
            if not client.pending:
                break
            try:
                sent = client.connection.send(client.pending)
            except BlockingIOError:
                self._selector.modify(
                    client.connection, selectors.EVENT_READ | selectors.EVENT_WRITE, client
                )
                return
            except OSError:
                self._drop(client)
                return
            client.pending = client.pending[sent:]
        if client.coding is None:
            self._drop(client)
        else:
            self._selector.modify(client.connection, selectors.EVENT_READ, client)

    def _next_part(self, client: _Client) -> bytes:
        image, coding = self._latest, client.coding
        if image is None or coding is None or image.sequence <= client.sequence:
            return b""
        client.sequence = image.sequence
        if coding.suffix not in self._parts:
            self._parts[coding.suffix] = part(image, coding)
        return self._parts[coding.suffix]

    def _drop(self, client: _Client) -> None:
        del self._clients[client.connection]
        self._selector.unregister(client.connection)
        client.connection.close()
        self._count_viewers()

    def _count_viewers(self) -> None:
        self.has_viewers = any(
            client.coding is not None and not client.watches for client in self._clients.values()
        )


def _listen(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.settimeout(0.0)
    try:
        listener.bind((LOOPBACK, port))
        listener.listen()
    except OSError as error:
        listener.close()
        if error.errno == errno.EADDRINUSE:
            raise LinkError(
                f"camera port {port} is in use: another vehicle probably runs; "
                "choose another with --instance or --camera-port"
            ) from None
        raise LinkError(f"camera port {port}: {error.strerror}") from None
    return listener
