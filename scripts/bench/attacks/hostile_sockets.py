"""The two who share a vehicle's links with its companion: a ground station, and the attacker."""

import contextlib
import socket
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from scripts.bench.attacks.hostile_datagrams import Generator

HOST = "127.0.0.1"
VEHICLE_PORTS = (18570, 14580)  # + instance
MAX_QUEUE_BYTES = 300_000  # waiting at the vehicle: more, and the system would drop some
HEARTBEAT, MISSION_CURRENT = 0, 42
AUTOPILOT, REFEREE = 1, 25
COMPLETE = 5  # MISSION_STATE


class Observer:
    """The ground station's end: follows mode and course, and remembers packets."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.socket.bind((HOST, 0))
        self.socket.settimeout(0.0)
        self.port: int = self.socket.getsockname()[1]
        self.system = 1
        self.mode = 0
        self.is_over = False
        self.is_partner = False

    def look(self, generator: Generator, modes: Counter[int]) -> None:
        """Read what has come in, and count modes until the course is over."""
        with contextlib.suppress(BlockingIOError):
            while True:
                data, vehicle = self.socket.recvfrom(4096)
                if not self.is_partner:  # claim the link before anybody else does
                    self.is_partner = True
                    self.socket.sendto(generator.hello(), vehicle)
                for raw in packets(data):
                    self._note(raw, modes)
                    generator.overhear(raw)

    def _note(self, raw: bytes, modes: Counter[int]) -> None:
        component, number = raw[6], int.from_bytes(raw[7:10], "little")
        payload = raw[10 : 10 + raw[1]].ljust(64, b"\0")
        if raw[5] != self.system or component not in (AUTOPILOT, REFEREE):
            return
        if component == AUTOPILOT and number == HEARTBEAT:
            self.mode = int.from_bytes(payload[:4], "little")
            modes[self.mode] += not self.is_over
        elif component == REFEREE and number == MISSION_CURRENT:
            self.is_over = payload[4] >= COMPLETE - 1


def packets(datagram: bytes) -> Iterator[bytes]:
    """Cut a datagram of the vehicle into its packets."""
    position = 0
    while position + 12 <= len(datagram) and datagram[position] == 0xFD:
        size = datagram[position + 1] + 12 + 13 * (datagram[position + 2] & 1)
        yield datagram[position : position + size]
        position += size


class Attack:
    """Some senders that take turns, on both of the vehicle's links, or on other ports."""

    def __init__(
        self, generator: Generator, instance: int, ports: Sequence[int] | None = None
    ) -> None:
        self._datagrams = iter(generator)
        self._sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
        self._ports = ports or [port + instance for port in VEHICLE_PORTS]
        self._turn = 0
        self.sent = 0

    def close(self) -> None:
        """Free the ports."""
        for sender in self._sockets:
            sender.close()

    def send(self, count: int) -> None:
        """Send so many, if the vehicle has room for them."""
        queued, _ = self.queue()
        if queued > MAX_QUEUE_BYTES:
            time.sleep(0.001)
            return
        for _ in range(count):
            self._turn += 1
            sender = self._sockets[self._turn % len(self._sockets)]
            port = self._ports[self._turn // 7 % len(self._ports)]
            sender.sendto(next(self._datagrams), (HOST, port))
        self.sent += count

    def queue(self) -> tuple[int, int]:
        """Say how many bytes wait at the vehicle's ports, at most, and what was dropped."""
        waiting = dropped = 0
        for line in Path("/proc/net/udp").read_text().splitlines()[1:]:
            columns = line.split()
            if int(columns[1].rpartition(":")[2], 16) in self._ports:
                waiting = max(waiting, int(columns[4].rpartition(":")[2], 16))
                dropped += int(columns[-1])
        return waiting, dropped
