"""The companion's link to a real PX4, byte for byte through us, so that we can add to it and watch.

PX4 (14580 + i) <-> (14540 + i) relay <-> companion. What either says is passed on unchanged and in
order; several of PX4's packets may leave in one datagram. On the way it is noted how old PX4's
attitude is, and what the companion says is read as well as passed on.
"""

from collections.abc import Iterator
from contextlib import suppress

from sitl.mavlink.links.link import LOOPBACK, Guard
from sitl.mavlink.links.udp_link import RECEIVE_BYTES, LinkConfig, UdpLink, bind
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import MAGIC_V2, Received, split

PX4_PORT, RELAY_PORT = 14580, 14540  # PX4's offboard API link: its end, where it sends; + instance
RELAY_PORT_LAST = 14549  # PX4 stops there
HEADER_BYTES, CHECKSUM_BYTES = 10, 2  # of MAVLink 2
ATTITUDE: int = mavlink.MAVLINK_MSG_ID_ATTITUDE


def relay_ports(instance: int) -> LinkConfig:
    """Say where the PX4 of an instance sends to, and where it listens."""
    local = min(RELAY_PORT + instance, RELAY_PORT_LAST)
    return LinkConfig(name="px4", local_port=local, remote_port=PX4_PORT + instance)


class CompanionLink(UdpLink):
    """The companion's side: a link of our components, which passes on what comes in."""

    def __init__(
        self, config: LinkConfig, px4_side: "Px4Side", *, system: int, index: int, guard: Guard
    ) -> None:
        """Bind the local port; raises LinkError where it cannot be had."""
        super().__init__(config, system=system, index=index, guard=guard)
        self._px4_side = px4_side

    def pass_on(self, datagram: bytes) -> None:
        """Send what PX4 said, as it is."""
        for tap in self._taps:
            tap.record(*(received.raw for received in split(datagram)), link=self.index)
        self._emit(datagram)

    def _judge(self, datagram: bytes) -> list[Received]:
        self._px4_side.send(datagram)
        return super()._judge(datagram)


class Px4Side:
    """The socket to which PX4 sends, as it would to a companion."""

    def __init__(self, ports: LinkConfig) -> None:
        """Bind the companion's port, PX4 being the remote; raises LinkError if it is taken."""
        self._socket = bind(ports)
        self._px4 = (LOOPBACK, ports.remote_port)
        self.link: CompanionLink | None = None  # where it goes on
        self.attitude_us = -1  # PX4's clock: of the newest ATTITUDE, -1 before the first

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

    def send(self, datagram: bytes) -> None:
        """Send to PX4; where there is none, it is lost."""
        with suppress(OSError):
            self._socket.sendto(datagram, self._px4)

    def serve(self, timeout_s: float = 0.0) -> None:
        """Pass on what PX4 has said; with a time, wait for something first, at most so long."""
        self._socket.settimeout(timeout_s)
        with suppress(OSError):  # nothing, any more
            while self.link is not None:
                datagram = self._socket.recv(RECEIVE_BYTES)
                self._socket.settimeout(0.0)
                self._note_attitude(datagram)
                self.link.pass_on(datagram)

    def forget(self) -> None:
        """Forget how old the attitude was: another PX4 has come."""
        self.attitude_us = -1

    def _note_attitude(self, datagram: bytes) -> None:
        for message_id, payload in _packets(datagram):
            if message_id == ATTITUDE:
                self.attitude_us = int.from_bytes(payload[:4], "little") * 1000  # time_boot_ms


Relay = tuple[CompanionLink, Px4Side]


def _packets(datagram: bytes) -> Iterator[tuple[int, bytes]]:
    """Walk through unsigned MAVLink 2 packets: each one's message id and payload."""
    start = 0
    while len(datagram) - start > HEADER_BYTES and datagram[start] == MAGIC_V2:
        begin = start + HEADER_BYTES
        end = begin + datagram[start + 1]
        yield int.from_bytes(datagram[start + 7 : begin], "little"), datagram[begin:end]
        start = end + CHECKSUM_BYTES
