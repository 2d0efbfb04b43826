"""Answer questions about time: TIMESYNC and PING."""

from sitl.mavlink.servers.request import Request
from sitl.mavlink.wire.dialect import Message, mavlink


def answer_timesync(message: Message, request: Request, time_us: int) -> None:
    """Answer a request (tc1 = 0) with our time since boot, in ns."""
    if message.tc1 == 0:
        request.outlet.send(mavlink.MAVLink_timesync_message(time_us * 1000, message.ts1))


def answer_ping(message: Message, request: Request) -> None:
    """Answer a question to everybody with its own number and time; an answer to us needs none."""
    if message.target_system == 0 and message.target_component == 0:
        request.outlet.send(
            mavlink.MAVLink_ping_message(
                message.time_usec, message.seq, request.system, request.component
            )
        )
