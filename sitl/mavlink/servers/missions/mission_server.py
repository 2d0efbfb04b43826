"""The mission protocol's server: upload, download, clear, and word of the mission's progress.

Three lists, one way for all: missions, fences, rally points. An upload is kept apart until it is
whole, so that the vehicle never has half a plan; there is one at a time, whoever it comes from.
What was lost on the way comes again: an upload's last item, too, though it has long ended, and gets
the answer that it had (PX4 main, mavlink_mission.cpp: handle_mission_item_both).
"""

from collections.abc import Callable, Mapping

from sitl.mavlink.servers.missions.mission_items import read_item, write_float_item, write_item
from sitl.mavlink.servers.missions.mission_transfer import Download, Upload
from sitl.mavlink.servers.request import Outlet, Request
from sitl.mavlink.streams.health import mission_progress
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.missions import MissionResult, PlanKind
from sitl.records.texts import CRITICAL, StatusText

MAX_ITEMS = {PlanKind.MISSION: 1000, PlanKind.FENCE: 128, PlanKind.RALLY: 32}


class MissionServer:
    """The autopilot component's side of the mission protocol."""

    def __init__(
        self,
        vehicle: SimulatedVehicle,
        broadcast: Callable[[Message], None],
        say: Callable[[StatusText], None],
    ) -> None:
        self._vehicle = vehicle
        self._missions = vehicle.autopilot.missions
        self._broadcast = broadcast
        self._say = say
        self._upload: Upload | None = None
        self._ended: Upload | None = None  # the one before
        self._downloads: dict[Outlet, Download] = {}  # one per link
        self._told = self._missions.progress
        self.handlers: Mapping[int, Callable[[Message, Request], None]] = {
            mavlink.MAVLINK_MSG_ID_MISSION_COUNT: self.count,
            mavlink.MAVLINK_MSG_ID_MISSION_ITEM: self.item,
            mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: self.item,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: self.request_list,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST: self.request_item,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT: self.request_item,
            mavlink.MAVLINK_MSG_ID_MISSION_ACK: self.acknowledged,
            mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: self.clear,
            mavlink.MAVLINK_MSG_ID_MISSION_SET_CURRENT: self.set_current,
        }

    def count(self, message: Message, request: Request) -> None:
        """Begin an upload: MISSION_COUNT."""
        kind, upload = _kind_of(message), self._upload
        if kind is None:
            _acknowledge(request, message.mission_type, MissionResult.UNSUPPORTED)
        elif upload is not None and not (upload.is_with(request) and upload.next == 0):
            _acknowledge(request, kind, MissionResult.ERROR)  # another upload is under way
        elif message.count > MAX_ITEMS[kind]:
            self._end_upload()
            _acknowledge(request, kind, MissionResult.NO_SPACE)
        elif message.count == 0:
            self._end_upload()
            _acknowledge(request, kind, self._missions.replace(kind, (), 0))
        else:
            now = self._vehicle.time_us
            self._upload = Upload(
                kind=kind, request=request, heard_us=now, sent_us=now, count=message.count
            )
            self._ask(self._upload)

    def item(self, message: Message, request: Request) -> None:
        """Take an item of the upload: MISSION_ITEM_INT or MISSION_ITEM."""
        upload = self._upload or self._ended
        if upload is None or not upload.is_with(request):
            self._complain("REJ. MIS ITEM: partner id mismatch\t")
        elif message.mission_type != upload.kind:
            _acknowledge(request, upload.kind, MissionResult.ERROR)
        elif self._upload is None:
            self._answer_again(upload, message.seq)
        elif message.seq == upload.next:
            self._take(message, upload)
        else:  # late or early: what is due will be asked for again
            upload.heard_us = self._vehicle.time_us

    def _answer_again(self, ended: Upload, sequence: int) -> None:
        """Answer an item that comes after the end: the last one, whose answer has been lost."""
        is_last = ended.result is not None and sequence == ended.next - 1
        if not is_last:
            self._complain("IGN MISSION_ITEM: No transfer\t")
        result = ended.result if is_last and ended.result is not None else MissionResult.ERROR
        _acknowledge(ended.request, ended.kind, result)

    def _take(self, message: Message, upload: Upload) -> None:
        upload.heard_us = self._vehicle.time_us
        item = read_item(message)
        if not isinstance(item, MissionResult):
            refusal = self._missions.check(upload.kind, item)
            if refusal is MissionResult.ACCEPTED:
                if upload.take(item, current=message.current == 1):
                    self._finish(upload)
                else:
                    self._ask(upload)
                return
            item = refusal
        self._end_upload()
        _acknowledge(upload.request, upload.kind, item)

    def request_list(self, message: Message, request: Request) -> None:
        """Begin a download: MISSION_REQUEST_LIST."""
        kind, running = _kind_of(message), self._downloads.get(request.outlet)
        if kind is None:
            _acknowledge(request, message.mission_type, MissionResult.UNSUPPORTED)
            return
        is_again = running and running.is_with(request) and running.kind is kind
        if running and running.next < len(running.plan) and not is_again:
            return  # as PX4: the one that runs goes on
        now, plan = self._vehicle.time_us, self._missions.plan(kind)
        self._downloads[request.outlet] = Download(
            kind=kind, request=request, heard_us=now, sent_us=now, plan=plan
        )
        request.outlet.send(
            mavlink.MAVLink_mission_count_message(
                request.system, request.component, len(plan), kind
            )
        )

    def request_item(self, message: Message, request: Request) -> None:
        """Give an item of the download: MISSION_REQUEST_INT or MISSION_REQUEST."""
        download = self._downloads.get(request.outlet)
        if download is None or not download.is_with(request):
            return  # silent, as PX4
        if message.mission_type != download.kind:
            return
        download.heard_us = self._vehicle.time_us
        item = download.give(message.seq)
        if item is None:
            del self._downloads[request.outlet]
            _acknowledge(request, download.kind, MissionResult.ERROR)
            return
        is_float = message.get_msgId() == mavlink.MAVLINK_MSG_ID_MISSION_REQUEST
        is_mission = download.kind is PlanKind.MISSION
        request.outlet.send(
            (write_float_item if is_float else write_item)(
                item,
                kind=download.kind,
                sequence=message.seq,
                current=is_mission and message.seq == self._missions.progress.sequence,
                request=request,
            )
        )

    def acknowledged(self, message: Message, request: Request) -> None:
        """End a download, or cancel an upload: MISSION_ACK."""
        download, upload = self._downloads.get(request.outlet), self._upload
        if download and download.is_with(request) and message.mission_type == download.kind:
            del self._downloads[request.outlet]
        elif upload and upload.is_with(request) and message.type == MissionResult.CANCELLED:
            self._end_upload()
        elif upload and upload.is_with(request) and message.type == MissionResult.UNSUPPORTED:
            upload.floats = not upload.floats
            self._ask(upload)

    def clear(self, message: Message, request: Request) -> None:
        """Empty one list, or all of them: MISSION_CLEAR_ALL."""
        kind = _kind_of(message)
        if kind is None and message.mission_type != mavlink.MAV_MISSION_TYPE_ALL:
            _acknowledge(request, message.mission_type, MissionResult.UNSUPPORTED)
        elif self._upload is not None:
            self._complain("WPM: IGN CLEAR CMD: Busy\t")  # and no answer, as PX4
        else:
            results = [self._missions.replace(k, (), 0) for k in PlanKind if kind in (k, None)]
            _acknowledge(request, message.mission_type, max(results))

    def set_current(self, message: Message, _request: Request) -> None:
        """Go to an item: MISSION_SET_CURRENT."""
        if self._upload is not None:
            self._complain("WPM: IGN WP CURR CMD: Busy\t")
        elif self._missions.set_current(message.seq):
            self._told = self._missions.progress
            self._broadcast(mission_progress(self._told))
        else:
            self._complain("WPM: WP CURR CMD: Not in list\t")

    def advance(self) -> None:
        """Tell what has happened since the last tick, ask again for what is late, give up."""
        for sequence in self._missions.drain_reached():
            self._broadcast(mavlink.MAVLink_mission_item_reached_message(sequence))
        progress = self._missions.progress
        if progress != self._told:
            self._told = progress
            self._broadcast(mission_progress(progress))
        if self._upload is not None or self._downloads:
            self._check_time(self._vehicle.time_us)

    def _check_time(self, time_us: int) -> None:
        upload = self._upload
        if upload is not None and upload.is_over(time_us):
            self._end_upload()
            self._complain("Operation timeout\t")
        elif upload is not None and upload.must_repeat(time_us):
            self._ask(upload)
        for outlet, download in list(self._downloads.items()):
            if download.is_over(time_us):
                del self._downloads[outlet]

    def _ask(self, upload: Upload) -> None:
        upload.sent_us = self._vehicle.time_us
        request = upload.request
        write = mavlink.MAVLink_mission_request_int_message
        if upload.floats:
            write = mavlink.MAVLink_mission_request_message
        request.outlet.send(write(request.system, request.component, upload.next, upload.kind))

    def _finish(self, upload: Upload) -> None:
        """Hand the whole plan over; the vehicle may still refuse it."""
        self._end_upload()
        upload.result = self._missions.replace(upload.kind, tuple(upload.items), upload.current)
        _acknowledge(upload.request, upload.kind, upload.result)

    def _end_upload(self) -> None:
        if self._upload is not None:
            self._ended, self._upload = self._upload, None

    def _complain(self, text: str) -> None:
        self._say(StatusText(severity=CRITICAL, text=text))


def _kind_of(message: Message) -> PlanKind | None:
    known = message.mission_type in iter(PlanKind)
    return PlanKind(message.mission_type) if known else None


def _acknowledge(request: Request, kind: int, result: MissionResult) -> None:
    request.outlet.send(
        mavlink.MAVLink_mission_ack_message(request.system, request.component, result, kind)
    )
