"""Answer the event protocol: this vehicle has no events, and says so."""

from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.health import EVENT_SEQUENCE
from sitl.mavlink.wire.dialect import Message
from sitl.mavlink.wire.newer_messages import ResponseEventError

UNAVAILABLE = 0  # MAV_EVENT_ERROR_REASON


def answer_request(message: Message, request: Request) -> None:
    """Answer REQUEST_EVENT, however many it asks for, by one RESPONSE_EVENT_ERROR."""
    request.outlet.send(
        ResponseEventError(
            message.first_sequence, EVENT_SEQUENCE, request.system, request.component, UNAVAILABLE
        )
    )
