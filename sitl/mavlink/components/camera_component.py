"""The camera as a MAVLink component of its own: who it is, where its stream is, when it looked."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.mavlink.servers.command_server import acknowledge
from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.health import component_heartbeat
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.images import ImageStamp
from sitl.records.mavlink_numbers import MavResult

VENDOR, MODEL = b"flightstack", b"sitl camera"
FIRMWARE = 1  # major 1
STREAM_ID = 1
REQUEST_CAMERA_INFORMATION = 521  # older ways to ask, which clients still use
REQUEST_VIDEO_STREAM_INFORMATION = 2504


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraFacts:
    """What the camera tells about itself."""

    stream_uri: str
    width_px: int
    height_px: int
    field_of_view_deg: int  # horizontal
    rate_hz: float


class CameraComponent:
    """Answer the camera protocol as far as a fixed camera with one stream needs it."""

    def __init__(self, facts: CameraFacts) -> None:
        self._facts = facts
        self._time_ms = 0
        self._requestable: Mapping[int, Callable[[], Message]] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self.heartbeat,
            mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION: self._information,
            mavlink.MAVLINK_MSG_ID_CAMERA_SETTINGS: self._settings,
            mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION: self._stream_information,
            mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_STATUS: self._stream_status,
        }

    def heartbeat(self) -> Message:
        """Say that the camera is there."""
        return component_heartbeat(mavlink.MAV_TYPE_CAMERA)

    def trigger(self, stamp: ImageStamp) -> Message:
        """Say that an image was taken: CAMERA_TRIGGER with the image's own stamp and number."""
        return mavlink.MAVLink_camera_trigger_message(stamp.time_us, stamp.sequence & 0xFFFFFFFF)

    def handle(self, message: Message, request: Request, time_us: int) -> None:
        """Answer a command addressed to the camera."""
        self._time_ms = time_us // 1000
        requested = {
            mavlink.MAV_CMD_REQUEST_MESSAGE: message.param1,
            REQUEST_CAMERA_INFORMATION: mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION,
            REQUEST_VIDEO_STREAM_INFORMATION: mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION,
        }.get(message.command)
        if requested is None:
            acknowledge(request, message.command, MavResult.UNSUPPORTED)
            return
        encode = self._requestable.get(requested)
        if encode is not None:
            request.outlet.send(encode())
        result = MavResult.DENIED if encode is None else MavResult.ACCEPTED
        acknowledge(request, message.command, result)

    def _information(self) -> Message:
        return mavlink.MAVLink_camera_information_message(
            self._time_ms,
            VENDOR.ljust(32, b"\0"),
            MODEL.ljust(32, b"\0"),
            FIRMWARE,
            0.0,
            0.0,
            0.0,
            self._facts.width_px,
            self._facts.height_px,
            0,
            mavlink.CAMERA_CAP_FLAGS_HAS_VIDEO_STREAM,
            0,
            b"",
        )

    def _settings(self) -> Message:
        return mavlink.MAVLink_camera_settings_message(self._time_ms, mavlink.CAMERA_MODE_VIDEO)

    def _stream_information(self) -> Message:
        facts = self._facts
        return mavlink.MAVLink_video_stream_information_message(
            STREAM_ID,
            1,
            mavlink.VIDEO_STREAM_TYPE_TCP_MPEG,  # the nearest to images over HTTP
            mavlink.VIDEO_STREAM_STATUS_FLAGS_RUNNING,
            facts.rate_hz,
            facts.width_px,
            facts.height_px,
            self._bits_per_second(),
            0,
            facts.field_of_view_deg,
            MODEL,
            facts.stream_uri.encode(),
        )

    def _stream_status(self) -> Message:
        facts = self._facts
        return mavlink.MAVLink_video_stream_status_message(
            STREAM_ID,
            mavlink.VIDEO_STREAM_STATUS_FLAGS_RUNNING,
            facts.rate_hz,
            facts.width_px,
            facts.height_px,
            self._bits_per_second(),
            0,
            facts.field_of_view_deg,
        )

    def _bits_per_second(self) -> int:
        """Say what the stream takes at most, uncompressed."""
        return round(self._facts.width_px * self._facts.height_px * 24 * self._facts.rate_hz)
