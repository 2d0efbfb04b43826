"""Where a message came from, and the way back to its sender."""

from dataclasses import dataclass
from typing import Protocol

from sitl.mavlink.streams.rates import StreamTable
from sitl.mavlink.wire.dialect import Message
from sitl.mavlink.wire.packets import Packed


class Outlet(Protocol):
    """What answers go out through: a link, in the name of one component."""

    def send(self, message: Message) -> None:
        """Send a message."""

    def send_packed(self, packed: Packed) -> None:
        """Send a packed message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """The envelope of a received message."""

    system: int  # the sender's
    component: int
    outlet: Outlet
    streams: StreamTable  # of the link it came by
