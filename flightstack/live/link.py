"""Listen to a vehicle as a ground station does, and ask for the gates and the camera's address.

Nothing else is sent, unless we are to be a ground station whose heartbeat counts: then the vehicle
tells the autopilot's texts, too, and may notice when we go. Nobody flies by what we send.
"""

from collections.abc import Iterable

from pymavlink.dialects.v20 import common

from flightstack.logs.columns.live import PieceReader
from flightstack.logs.columns.log import Log
from flightstack.mavlink.endpoint import Endpoint
from flightstack.mavlink.link import Message
from flightstack.mavlink.transport import Address, open_transport
from flightstack.mavlink_numbers import CAMERA_COMPONENT, REFEREE_COMPONENT

OUR_SYSTEM, OUR_COMPONENT = 254, 190  # MAV_COMP_ID_MISSIONPLANNER, beside a ground station's 255
MAX_GATES = 256  # of a course that is worth drawing
MAX_ASKED = 32  # items at a time
VIDEO_STREAM_INFORMATION = 269
GATES = common.MAV_MISSION_TYPE_MISSION


class LiveLink:
    """One endpoint; what comes is told as pieces of a log."""

    def __init__(self, endpoint: Endpoint, *, beats: bool = False) -> None:
        """Open it; raises LinkError."""
        self._transport = open_transport(endpoint)
        self._reader = PieceReader()
        self._sender = common.MAVLink(None, OUR_SYSTEM, OUR_COMPONENT)
        self._address: Address | None = None  # of whoever was heard last
        self._beats = beats
        self._questions = Questions()

    @property
    def host(self) -> str | None:
        """Where the vehicle was heard; None on a serial line, or before."""
        return self._address[0] if self._address else None

    @property
    def camera_uri(self) -> str | None:
        """What the vehicle calls its camera's address; None before it has said."""
        return self._questions.camera_uri

    def fileno(self) -> int:
        """Return what a selector waits on."""
        return self._transport.fileno()

    def receive(self) -> Log:
        """Return the packets that have come, without times of their own."""
        parts: list[bytes] = []
        for packets, address in self._transport.receive():
            parts += packets
            self._address = address or self._address
        log = self._reader.feed(b"".join(parts))
        self._questions.hear(log)
        return log

    def ask(self, system: int | None) -> None:
        """Send what there is to ask of the vehicle; once a second or so."""
        messages: list[Message] = []
        if self._beats:
            kinds = (common.MAV_TYPE_GCS, common.MAV_AUTOPILOT_INVALID)
            messages.append(common.MAVLink_heartbeat_message(*kinds, 0, 0, 0, 3))
        if system is not None:
            messages += self._questions.open(system)
        for message in messages:
            self._transport.send(message.pack(self._sender), self._address)
            self._sender.seq = (self._sender.seq + 1) % 256

    def close(self) -> None:
        """Let go of the port."""
        self._transport.close()


class Questions:
    """What is not yet known: how many gates there are, each of them, and where the camera is."""

    def __init__(self) -> None:
        self.camera_uri: str | None = None
        self._components: set[int] = set()
        self._count: int | None = None
        self._gates: set[int] = set()

    def hear(self, log: Log) -> None:
        """Take in what has been said, to whomever."""
        self._components |= set(log["HEARTBEAT"].component.tolist())
        counts = log["MISSION_COUNT"].where(component=REFEREE_COMPONENT)
        counts = counts.take(counts["mission_type"] == GATES)
        if len(counts):
            self._count = min(int(counts["count"][-1]), MAX_GATES)
        items = log["MISSION_ITEM_INT"].where(component=REFEREE_COMPONENT)
        self._gates |= set(items["seq"].tolist())
        streams = log["VIDEO_STREAM_INFORMATION"]
        if len(streams):
            self.camera_uri = str(streams["uri"][0])

    def open(self, system: int) -> Iterable[Message]:
        """Return the questions that are open; none to components that were never heard."""
        if REFEREE_COMPONENT in self._components:
            whom = (system, REFEREE_COMPONENT)
            if self._count is None:
                yield common.MAVLink_mission_request_list_message(*whom, GATES)
            missing = [n for n in range(self._count or 0) if n not in self._gates]
            for number in missing[:MAX_ASKED]:
                yield common.MAVLink_mission_request_int_message(*whom, number, GATES)
        if CAMERA_COMPONENT in self._components and self.camera_uri is None:
            command = common.MAV_CMD_REQUEST_MESSAGE
            asked = (float(VIDEO_STREAM_INFORMATION), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
            yield common.MAVLink_command_long_message(system, CAMERA_COMPONENT, command, 0, *asked)
