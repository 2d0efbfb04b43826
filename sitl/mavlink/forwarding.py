"""Forward messages of foreign components between the links, as PX4 does.

What addresses nobody goes to every other link; what addresses a component goes where that
component was seen. What addresses the vehicle stays. The table is bounded.
"""

from collections.abc import Sequence

from sitl.mavlink.dialect import AUTOPILOT, CAMERA, REFEREE, mavlink
from sitl.mavlink.framing import Received
from sitl.mavlink.link import Link

MAX_COMPONENTS = 32
OWN_COMPONENTS = {AUTOPILOT, REFEREE, CAMERA}
NEVER = {mavlink.MAVLINK_MSG_ID_SETUP_SIGNING}


class Forwarder:
    """Remember who was seen where, and pass messages on unchanged."""

    def __init__(self, links: Sequence[Link], system: int) -> None:
        self._links = links
        self._system = system
        self._seen: dict[tuple[int, int], int] = {}  # (system, component): link index

    def forward(self, received: Received, source: Link) -> None:
        """Pass one message on."""
        sender = (received.system, received.component)
        if received.system == self._system and received.component in OWN_COMPONENTS:
            return  # nobody else speaks in our name
        if sender in self._seen or len(self._seen) < MAX_COMPONENTS:
            self._seen[sender] = source.index
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
        return any(
            index == link.index and seen == system and component in (0, seen_component)
            for (seen, seen_component), index in self._seen.items()
        )
