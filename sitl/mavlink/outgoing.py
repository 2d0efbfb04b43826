"""Send what the vehicle says by itself: streams and texts, each encoded once for all links."""

import itertools
from collections.abc import Callable, Sequence

from sitl.mavlink.dialect import AUTOPILOT, Message
from sitl.mavlink.encoders import ENCODERS
from sitl.mavlink.framing import Packet, pack
from sitl.mavlink.link import Link
from sitl.mavlink.streams import GROUND_STATION, OFFBOARD_API, StreamTable
from sitl.mavlink.texts import TAB, statustexts
from sitl.mavlink.view import View
from sitl.records import StatusText

API_INDEX = 1  # the offboard API's link; all others are ground stations'


class Port:
    """A link as one component uses it."""

    def __init__(self, link: Link, component: int) -> None:
        self._link, self._component = link, component

    def send(self, message: Message) -> None:
        """Send a message."""
        self._link.send(message, self._component)

    def send_packet(self, packet: Packet) -> None:
        """Send a packed message."""
        self._link.send_packet(packet, self._component)


class Outgoing:
    """All links at once."""

    def __init__(self, links: Sequence[Link]) -> None:
        self._links = links
        self.streams = [
            StreamTable(OFFBOARD_API if link.index == API_INDEX else GROUND_STATION)
            for link in links
        ]

    def broadcast(self, message: Message, component: int = AUTOPILOT) -> None:
        """Send a message on every link."""
        self.broadcast_packet(pack(message), component)

    def broadcast_packet(self, packet: Packet, component: int = AUTOPILOT) -> None:
        """Send a packed message on every link."""
        for link in self._links:
            link.send_packet(packet, component)

    def say(self, text: StatusText) -> None:
        """Send one of the vehicle's texts on the links that have heard a ground station."""
        line = text.text.rstrip(TAB) + TAB
        for link in self._links:
            if link.gcs_heard:
                for message in statustexts(text.severity, line, link.next_text_id()):
                    link.send(message)

    def send_streams(self, time_us: int, make_view: Callable[[], View]) -> None:
        """Send what the links' tables say is due, each link's in one datagram."""
        due = [streams.due(time_us) for streams in self.streams]
        if not any(due):
            return
        view = make_view()
        packets: dict[int, Packet | None] = {}
        for message_id in itertools.chain(*due):
            if message_id not in packets:
                message = ENCODERS[message_id](view)
                packets[message_id] = None if message is None else pack(message)
        for link, message_ids in zip(self._links, due, strict=True):
            known = (packets[message_id] for message_id in message_ids)
            link.send_together([packet for packet in known if packet is not None])
