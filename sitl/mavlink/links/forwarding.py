"""Forward messages of foreign components between the links, as PX4 does.

What addresses nobody goes to every other link; what addresses a component goes where that
component was seen. What addresses the vehicle stays. Each link has a table of its own, bounded: a
flood of invented components can push out what was seen on its own link only, and that comes back
with its next message.
"""

from collections import OrderedDict
from collections.abc import Sequence

from sitl.mavlink.links.link import Link
from sitl.mavlink.wire.dialect import OWN_COMPONENTS, mavlink
from sitl.mavlink.wire.packets import Received

MAX_COMPONENTS = 32  # of each link
Component = tuple[int, int]  # system, component
NEVER = {mavlink.MAVLINK_MSG_ID_SETUP_SIGNING}


class Forwarder:
    """Remember who was seen where, and pass messages on unchanged."""

    def __init__(self, links: Sequence[Link], system: int) -> None:
        self._links = links
        self._system = system
        self._seen: dict[Link, OrderedDict[Component, None]] = {
            link: OrderedDict() for link in links
        }

    def forward(self, received: Received, source: Link) -> None:
        """Pass one message on."""
        if received.system == self._system and received.component in OWN_COMPONENTS:
            return  # nobody else speaks in our name
        self._note(self._seen[source], (received.system, received.component))
        if received.message_id in NEVER:
            return
        for link in self._links:
            if link is not source and self._wants(link, received):
                link.send_raw(received.raw)

    def _wants(self, link: Link, received: Received) -> bool:
        system = getattr(received.message, "target_system", 0)
        component = getattr(received.message, "target_component", 0)
        if system == 0:
            return True
        if system == self._system and component in OWN_COMPONENTS | {0}:
            return False
        if component != 0:
            return (system, component) in self._seen[link]
        return any(seen == system for seen, _ in self._seen[link])

    @staticmethod
    def _note(seen: OrderedDict[Component, None], sender: Component) -> None:
        seen[sender] = None
        seen.move_to_end(sender)
        if len(seen) > MAX_COMPONENTS:
            seen.popitem(last=False)
