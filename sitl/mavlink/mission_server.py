"""Answer the mission protocol: there is no mission, and none can be uploaded."""

from sitl.mavlink.dialect import Message, mavlink
from sitl.mavlink.request import Request

MISSION_TYPES = (
    mavlink.MAV_MISSION_TYPE_MISSION,
    mavlink.MAV_MISSION_TYPE_FENCE,
    mavlink.MAV_MISSION_TYPE_RALLY,
)
ACCEPTED = mavlink.MAV_MISSION_ACCEPTED
UNSUPPORTED = mavlink.MAV_MISSION_UNSUPPORTED


def answer_list(message: Message, request: Request) -> None:
    """Answer MISSION_REQUEST_LIST: every list is empty."""
    if message.mission_type not in MISSION_TYPES:
        _acknowledge(message, request, UNSUPPORTED)
        return
    request.outlet.send(
        mavlink.MAVLink_mission_count_message(
            request.system, request.component, 0, message.mission_type
        )
    )


def answer_upload(message: Message, request: Request) -> None:
    """Answer MISSION_COUNT: nothing to upload is fine, items are refused."""
    _acknowledge(message, request, ACCEPTED if message.count == 0 else UNSUPPORTED)


def answer_clear(message: Message, request: Request) -> None:
    """Answer MISSION_CLEAR_ALL: it is clear already."""
    _acknowledge(message, request, ACCEPTED)


def _acknowledge(message: Message, request: Request, result: int) -> None:
    request.outlet.send(
        mavlink.MAVLink_mission_ack_message(
            request.system, request.component, result, message.mission_type
        )
    )
