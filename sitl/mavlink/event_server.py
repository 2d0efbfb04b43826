"""Answer the event protocol: this vehicle has no events, and says so."""

from sitl.mavlink.dialect import Message
from sitl.mavlink.newer_messages import CurrentEventSequence, ResponseEventError
from sitl.mavlink.request import Request
from sitl.mavlink.view import View

SEQUENCE = 0
RESET = 1  # MAV_EVENT_CURRENT_SEQUENCE_FLAGS: there are none
UNAVAILABLE = 0  # MAV_EVENT_ERROR_REASON


def current_event_sequence(_view: View) -> Message:
    """CURRENT_EVENT_SEQUENCE: no event so far."""
    return CurrentEventSequence(SEQUENCE, RESET)


def answer_request(message: Message, request: Request) -> None:
    """Answer REQUEST_EVENT, however many it asks for, by one RESPONSE_EVENT_ERROR."""
    request.outlet.send(
        ResponseEventError(
            message.first_sequence, SEQUENCE, request.system, request.component, UNAVAILABLE
        )
    )
