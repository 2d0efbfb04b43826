"""Send what the vehicle says by itself: streams and texts, each encoded once for all links."""

from collections.abc import Callable, Sequence

from sitl.mavlink.links.link import Link
from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.rates import GROUND_STATION, OFFBOARD_API, StreamTable
from sitl.mavlink.streams.view import View
from sitl.mavlink.wire.dialect import AUTOPILOT, Message, mavlink
from sitl.mavlink.wire.packets import Packed, pack
from sitl.mavlink.wire.refusals import Refusal, Refusals
from sitl.mavlink.wire.texts import TAB, statustexts
from sitl.records.mavlink_numbers import MavResult
from sitl.records.missions import MissionResult
from sitl.records.texts import StatusText

COMMAND_IS_FINE = {MavResult.ACCEPTED, MavResult.IN_PROGRESS}
PLAN_IS_FINE = {MissionResult.ACCEPTED, MissionResult.CANCELLED}
API_INDEX = 1  # the offboard API's link; all others are ground stations'


class ComponentOutlet:
    """A link as one component uses it; the refusals that go out by it are counted."""

    def __init__(self, link: Link, component: int, refusals: Refusals) -> None:
        self._link, self._component, self._refusals = link, component, refusals

    def send(self, message: Message) -> None:
        """Send a message."""
        refusal = _refusal(message)
        if refusal is not None:
            self._refusals.note([refusal])
        self._link.send(message, self._component)

    def send_packed(self, packed: Packed) -> None:
        """Send a packed message."""
        self._link.send_packed(packed, self._component)


def _refusal(message: Message) -> Refusal | None:
    """Say what an answer refuses, if it does."""
    message_id = message.get_msgId()
    if message_id == mavlink.MAVLINK_MSG_ID_COMMAND_ACK:
        is_refused = message.result not in COMMAND_IS_FINE
        return Refusal.COMMAND if is_refused else None
    if message_id == mavlink.MAVLINK_MSG_ID_MISSION_ACK:
        return Refusal.PLAN if message.type not in PLAN_IS_FINE else None
    return None


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
        self.broadcast_packed(pack(message), component)

    def broadcast_packed(self, packed: Packed, component: int = AUTOPILOT) -> None:
        """Send a packed message on every link."""
        for link in self._links:
            link.send_packed(packed, component)

    def say(self, text: StatusText) -> None:
        """Send one of the vehicle's texts on the links that have heard a ground station."""
        line = text.text.rstrip(TAB) + TAB
        for link in self._links:
            if link.gcs_heard:
                for message in statustexts(text.severity, line, link.next_text_id()):
                    link.send(message)

    def send_streams(self, time_us: int, make_view: Callable[[], View]) -> None:
        """Send what the links' tables say is due, each link's together."""
        view: View | None = None
        packed: dict[int, Packed | None] = {}
        for link, streams in zip(self._links, self.streams, strict=True):
            due = streams.due(time_us)
            if not due:
                continue
            view = view or make_view()
            for message_id in due:
                if message_id not in packed:
                    message = ENCODERS[message_id](view)
                    packed[message_id] = None if message is None else pack(message)
            known = [packed[message_id] for message_id in due]
            link.send_together([each for each in known if each is not None])
