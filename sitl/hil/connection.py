"""The TCP port that PX4 connects to: one PX4 at a time, known by what it says first.

Whoever connects is a stranger until a whole MAVLink packet has come. Strangers who talk nonsense,
talk for long, or come while a PX4 is there are closed; what PX4 itself sends wrongly is skipped.
"""

import errno
import logging
import selectors
import socket

from sitl.errors import LinkError
from sitl.hil.messages import MotorCommand, read_motors
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import split_stream

MAX_STRANGERS = 8
MAX_STRANGE_BYTES = 512  # PX4's first packets are 77 bytes
RECEIVE_BYTES = 4096
MAX_PENDING_BYTES = 1 << 16  # 3 s of sensors: a PX4 that is further behind has stopped

Address = tuple[str, int]

_log = logging.getLogger(__name__)


class Px4Connection:
    """A non-blocking TCP server; has a selector of its own, to be nested."""

    def __init__(self, address: Address) -> None:
        """Listen.

        Raises:
            LinkError: the port cannot be had.

        """
        self._listener = _listen(address)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._strangers: dict[socket.socket, bytes] = {}
        self._px4: socket.socket | None = None
        self._unread = b""
        self._pending = bytearray()
        self._motors: MotorCommand | None = None
        self.connections = 0  # how many PX4s have come so far
        self.refused = 0  # strangers who were closed

    def close(self) -> None:
        """Free the port."""
        for stranger in list(self._strangers):
            self._close_stranger(stranger)
        self._drop()
        self._selector.close()
        self._listener.close()

    def fileno(self) -> int:
        """Give what becomes readable when `serve` has something to do."""
        return self._selector.fileno()

    @property
    def address(self) -> Address:
        """Where it listens."""
        host, port = self._listener.getsockname()
        return str(host), int(port)

    @property
    def is_connected(self) -> bool:
        """Whether a PX4 is there."""
        return self._px4 is not None

    @property
    def is_ready(self) -> bool:
        """Whether a PX4 is there and has taken all that was sent."""
        return self._px4 is not None and not self._pending

    @property
    def awaited(self) -> str:
        """What is waited for while there is none."""
        host, port = self.address
        return f"PX4 to connect to tcp {host}:{port}"

    def serve(self, timeout_s: float = 0.0) -> None:
        """Accept, read, send what waits; wait at most `timeout_s` for something to do."""
        for key, events in self._selector.select(timeout_s):
            if key.fileobj is self._listener:
                self._accept()
            elif key.fileobj is self._px4:
                if events & selectors.EVENT_WRITE:
                    self._flush()
                if events & selectors.EVENT_READ:
                    self._read()
            elif isinstance(key.fileobj, socket.socket) and key.fileobj in self._strangers:
                self._hear(key.fileobj)

    def send(self, data: bytes) -> None:
        """Send to PX4; what it cannot take now goes later, in order."""
        if self._px4 is None or len(self._pending) > MAX_PENDING_BYTES:
            return
        self._pending += data
        self._flush()

    def take_motors(self) -> MotorCommand | None:
        """Hand over the newest motor command since the last call; None if none came."""
        motors, self._motors = self._motors, None
        return motors

    def _accept(self) -> None:
        try:
            stranger, _ = self._listener.accept()
        except OSError:
            return  # it went away before we looked
        if self._px4 is not None or len(self._strangers) >= MAX_STRANGERS:
            stranger.close()
            self.refused += 1
            return
        stranger.settimeout(0.0)
        stranger.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._strangers[stranger] = b""
        self._selector.register(stranger, selectors.EVENT_READ)

    def _hear(self, stranger: socket.socket) -> None:
        """Find out whether a stranger is a PX4."""
        data = _receive(stranger)
        if data is None:
            return
        heard = self._strangers[stranger] + data
        messages, unread = split_stream(heard)
        if messages:
            self._welcome(stranger, unread)
        elif not data or not unread or len(heard) > MAX_STRANGE_BYTES:
            self._close_stranger(stranger)
            self.refused += 1
        else:
            self._strangers[stranger] = heard

    def _welcome(self, px4: socket.socket, unread: bytes) -> None:
        del self._strangers[px4]
        for stranger in list(self._strangers):
            self._close_stranger(stranger)
            self.refused += 1
        self._px4, self._unread = px4, unread
        self.connections += 1
        _log.info("PX4 has connected")

    def _close_stranger(self, stranger: socket.socket) -> None:
        del self._strangers[stranger]
        self._selector.unregister(stranger)
        stranger.close()

    def _read(self) -> None:
        if self._px4 is None:
            return
        data = _receive(self._px4)
        if data is None:
            return
        if not data:
            self._drop()
            return
        messages, self._unread = split_stream(self._unread + data)
        for received in messages:
            if received.message_id == mavlink.MAVLINK_MSG_ID_HIL_ACTUATOR_CONTROLS:
                self._motors = read_motors(received.message)

    def _flush(self) -> None:
        if self._px4 is None:
            return
        events = selectors.EVENT_READ
        try:
            while self._pending:
                del self._pending[: self._px4.send(self._pending)]
        except BlockingIOError:
            events |= selectors.EVENT_WRITE
        except OSError:
            self._drop()
            return
        if self._selector.get_key(self._px4).events != events:
            self._selector.modify(self._px4, events)

    def _drop(self) -> None:
        if self._px4 is None:
            return
        self._selector.unregister(self._px4)
        self._px4.close()
        self._px4 = self._motors = None
        self._unread = b""
        self._pending.clear()
        _log.warning("PX4 has gone; time stands until one connects")


def _receive(connection: socket.socket) -> bytes | None:
    """Read; None if nothing is there, nothing at all if the other side has gone."""
    try:
        return connection.recv(RECEIVE_BYTES)
    except BlockingIOError:
        return None
    except OSError:
        return b""


def _listen(address: Address) -> socket.socket:
    host, port = address
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.settimeout(0.0)
    try:
        listener.bind(address)
        listener.listen()
    except OSError as error:
        listener.close()
        reason = error.strerror or str(error)
        if error.errno == errno.EADDRINUSE:
            reason = "is in use: another simulator probably runs; choose another --instance"
        raise LinkError(f"PX4's simulator port {host}:{port}: {reason}") from None
    return listener
