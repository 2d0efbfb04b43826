"""One MAVLink link: sequence numbers, signatures, and a copy for whoever keeps the log.

What carries the bytes are its subclasses, `UdpLink` and `TcpLink`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Protocol

from sitl.mavlink.wire.dialect import AUTOPILOT, OWN_COMPONENTS, Message
from sitl.mavlink.wire.packets import Packed, Received, pack, wrap
from sitl.mavlink.wire.refusals import Refusal, Refusals
from sitl.mavlink.wire.signing import Signing

LOOPBACK = "127.0.0.1"
MAX_DATAGRAM_BYTES = 1400  # below any usual network's limit


class Tap(Protocol):
    """Whoever keeps a copy of the traffic."""

    def record(self, *packets: bytes, link: int) -> None:
        """Take packets of one moment, on link number `link`."""


class Radio(Protocol):
    """Whatever the bytes go through on their way out."""

    def carry(self, data: bytes, transmit: Callable[[bytes], None]) -> None:
        """Send the bytes, or what becomes of them, now or later or never."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Guard:
    """What all links of a vehicle share to keep others out."""

    signing: Signing = field(default_factory=Signing)
    refusals: Refusals = field(default_factory=Refusals)


class Link(ABC):
    """A way for MAVLink 2 packets in and out; never waits, never raises for what comes in."""

    def __init__(self, name: str, *, system: int, index: int, guard: Guard | None = None) -> None:
        """Name and number the link; links of one vehicle share a guard."""
        self.name = name
        self.index = index
        self.gcs_heard = False  # a ground station's HEARTBEAT came in: it wants STATUSTEXT
        self._taps: tuple[Tap, ...] = ()
        self._system = system
        self._guard = guard or Guard()
        self.radio: Radio | None = None  # what spoils the bytes on their way, if anything does
        self._sequences: dict[int, int] = {}
        self._texts = 0
        self._gathers = False
        self._gathered = b""

    @abstractmethod
    def close(self) -> None:
        """Free the port."""

    @abstractmethod
    def fileno(self) -> int:
        """For a selector."""

    @abstractmethod
    def describe(self) -> str:
        """Say what the link opens, for the vehicle's first line."""

    @property
    def is_open(self) -> bool:
        """Whether anybody may hear what is sent."""
        return True

    @abstractmethod
    def _transmit(self, data: bytes) -> None:
        """Send; what cannot be sent now is lost."""

    @abstractmethod
    def _take(self) -> list[Received] | None:
        """Take what has come in, up to one datagram; None if nothing waits."""

    @abstractmethod
    def _adopt_sender(self) -> None:
        """Note that who sent last has sent something good."""

    def add_tap(self, tap: Tap) -> None:
        """Let somebody keep a copy of all traffic from now on."""
        self._taps += (tap,)

    def send(self, message: Message, component: int = AUTOPILOT) -> None:
        """Send a message as one of the vehicle's components."""
        self.send_packed(pack(message), component)

    def send_packed(self, packed: Packed, component: int = AUTOPILOT) -> None:
        """Send a packed message as one of the vehicle's components."""
        if self.is_open:
            self.send_raw(self._wrap(packed, component))

    def send_together(self, messages: Iterable[Packed]) -> None:
        """Send the autopilot's packed messages in as few datagrams as hold them."""
        if not self.is_open:
            return
        packets = [self._wrap(packed, AUTOPILOT) for packed in messages]
        for tap in self._taps:
            tap.record(*packets, link=self.index)
        datagram = b""
        for raw in packets:
            if len(datagram) + len(raw) > MAX_DATAGRAM_BYTES:
                self._emit(datagram)
                datagram = b""
            datagram += raw
        if datagram:
            self._emit(datagram)

    def send_raw(self, raw: bytes) -> None:
        """Send a whole packet as it is."""
        for tap in self._taps:
            tap.record(raw, link=self.index)
        self._emit(raw)

    def gather(self) -> None:
        """Keep what is sent from now on until `flush`, so that it leaves in few datagrams."""
        self._gathers = True

    def flush(self) -> None:
        """Let go what was gathered."""
        if self._gathered:
            data, self._gathered = self._gathered, b""
            self._transmit(data)

    def _forget(self) -> None:
        """Drop what was gathered: whoever it was for has gone, a ground station or not."""
        self.gcs_heard = False
        self._gathered = b""

    def _emit(self, data: bytes) -> None:
        if self.radio is None and self._gathers:
            if len(self._gathered) + len(data) > MAX_DATAGRAM_BYTES:
                self.flush()
            self._gathered += data
        elif self.radio is None:
            self._transmit(data)
        else:
            self.flush()
            self.radio.carry(data, self._transmit)

    def next_text_id(self) -> int:
        """Give the number of this link's next text; PX4 counts them from 0."""
        number = self._texts
        self._texts = (number + 1) & 0xFFFF
        return number

    def receive(self) -> list[Received] | None:
        """Take what has come in, up to one datagram: the packets that may be heeded."""
        arrived = self._take()
        if arrived is None:
            return None
        messages = [received for received in arrived if self._accepts(received)]
        if any(received.is_signed or not self._guard.signing.is_on for received in messages):
            self._adopt_sender()
        for received in messages:
            for tap in self._taps:
                tap.record(received.raw, link=self.index)
        return messages

    def _accepts(self, received: Received) -> bool:
        signing = self._guard.signing
        refusal = signing.judge(received)
        if signing.is_on and self._is_own(received):
            refusal = Refusal.OWN_NAME  # authentic even: our own packet, sent back to us
        if refusal is not None:
            self._guard.refusals.note([refusal])
        return refusal is None

    def _is_own(self, received: Received) -> bool:
        return received.system == self._system and received.component in OWN_COMPONENTS

    def _wrap(self, packed: Packed, component: int) -> bytes:
        sequence = self._sequences.get(component, 0)
        self._sequences[component] = (sequence + 1) & 0xFF
        signing = self._guard.signing
        if not signing.is_on:
            return wrap(packed, sequence=sequence, system=self._system, component=component)
        raw = wrap(
            packed, sequence=sequence, system=self._system, component=component, is_signed=True
        )
        return raw + signing.signature(raw, self.index)
