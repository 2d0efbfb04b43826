"""A link whose other end is the test."""

from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common

from flightstack.clock import VehicleClock
from flightstack.mavlink.link import Link
from flightstack.mavlink.packets import split_packets
from flightstack.mavlink.signing import Signing
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import Address, Received

VEHICLE: Address = ("10.0.0.1", 14580)


class MemoryTransport:
    def __init__(self) -> None:
        self.closed = False
        self.partner: Address | None = None
        self.waiting: list[Received] = []
        self.sent: list[tuple[bytes, Address | None]] = []

    def fileno(self) -> int:
        raise NotImplementedError

    def receive(self) -> list[Received]:
        waiting, self.waiting = self.waiting, []
        return waiting

    def forget_backlog(self) -> None:
        self.waiting.clear()

    def listen_only_to(self, partner: Address | None) -> None:
        self.partner = partner

    def send(self, packets: bytes, address: Address | None) -> bool:
        self.sent.append((packets, address))
        return True

    def close(self) -> None:
        self.closed = True


class Wall:
    now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


class MadeLink:
    """A link, its clock, and the vehicle's mouth."""

    def __init__(
        self, folder: Path, signing: Signing | None = None, *, system: int | None = None
    ) -> None:
        self.transport = MemoryTransport()
        self.wall = Wall()
        self.clock = VehicleClock(self.wall)
        self.tlog = TlogWriter(folder / "link.tlog", self.wall)
        self.link = Link(self.transport, self.tlog, self.clock, signing=signing, system=system)

    def say(
        self, message: Any, system: int = 3, component: int = 1, address: Address = VEHICLE
    ) -> bytes:
        return self.hear(bytes(message.pack(common.MAVLink(None, system, component))), address)

    def hear(self, packet: bytes, address: Address = VEHICLE) -> bytes:
        self.transport.waiting.append((split_packets(packet)[0], address))
        return packet

    def sent(self) -> list[Any]:
        parser = common.MAVLink(None)
        return [parser.decode(bytearray(packet)) for packet, _ in self.transport.sent]


def heartbeat(
    *, autopilot: int = 12, mode: int = 0x03040000, base_mode: int = 29, status: int = 3
) -> Any:
    return common.MAVLink_heartbeat_message(2, autopilot, base_mode, mode, status, 3)
