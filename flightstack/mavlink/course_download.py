"""Download where the gates stand from the referee, so that the log can show them.

    LISTING --MISSION_COUNT--> FETCHING --last item--> CLOSING --MISSION_ACK--> DONE
       |                          |                                               ^
       +-- nothing to download ---+-- ATTEMPTS unanswered: nobody minds ----------+

Nobody flies by what comes: it stands in the log, as all that is received. One request goes out at
each `poll`, which the flight paces by its images, so that a vehicle in lockstep hears the same
messages at the same moment on every flight.
"""

from enum import Enum, auto

from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Link, Message
from flightstack.mavlink_numbers import COMPANION_COMPONENT, REFEREE_COMPONENT

RETRY_US = 500_000
ATTEMPTS = 4
MAX_GATES = 256  # of a course that is worth drawing
GATES = common.MAV_MISSION_TYPE_MISSION
ACCEPTED = common.MAV_MISSION_ACCEPTED


class DownloadStage(Enum):
    """How far the download has come."""

    LISTING = auto()
    FETCHING = auto()
    CLOSING = auto()
    DONE = auto()


AWAITED = {
    DownloadStage.LISTING: common.MAVLINK_MSG_ID_MISSION_COUNT,
    DownloadStage.FETCHING: common.MAVLINK_MSG_ID_MISSION_ITEM_INT,
}


class CourseDownload:
    """Ask the referee item by item; `now_us` is the caller's clock."""

    def __init__(self, link: Link) -> None:
        self.stage = DownloadStage.LISTING
        self.items = 0  # downloaded so far
        self._link = link
        self._count = 0
        self._attempts = 0
        self._sent_us: int | None = None  # None: nothing is awaited

    def poll(self, now_us: int) -> None:
        """Send the next request, or again one that was not answered in time."""
        if self.stage is DownloadStage.DONE:
            return
        if self._sent_us is not None and now_us - self._sent_us < RETRY_US:
            return
        if self._attempts >= ATTEMPTS:
            self.stage = DownloadStage.DONE
            return
        self._attempts += 1
        self._sent_us = now_us
        self._link.send(self._request())
        if self.stage is DownloadStage.CLOSING:
            self.stage = DownloadStage.DONE

    def take(self, message: Message) -> None:
        """Take a message of the referee; only the one that is awaited moves the download on."""
        if message.get_srcComponent() != REFEREE_COMPONENT:
            return
        if message.target_component != COMPANION_COMPONENT or message.mission_type != GATES:
            return
        if message.get_msgId() != AWAITED.get(self.stage):
            return
        if self.stage is DownloadStage.LISTING:
            self._count = message.count
            self._go_on()
        elif message.seq == self.items:
            self.items += 1
            self._go_on()

    def _go_on(self) -> None:
        self._attempts, self._sent_us = 0, None
        if not 0 < self._count <= MAX_GATES:
            self.stage = DownloadStage.DONE
        elif self.items < self._count:
            self.stage = DownloadStage.FETCHING
        else:
            self.stage = DownloadStage.CLOSING

    def _request(self) -> Message:
        if self.stage is DownloadStage.LISTING:
            return common.MAVLink_mission_request_list_message(*self._referee, GATES)
        if self.stage is DownloadStage.FETCHING:
            return common.MAVLink_mission_request_int_message(*self._referee, self.items, GATES)
        return common.MAVLink_mission_ack_message(*self._referee, ACCEPTED, GATES)

    @property
    def _referee(self) -> tuple[int, int]:
        return (self._link.system_id, REFEREE_COMPONENT)
