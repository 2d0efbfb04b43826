"""Fly a companion and a vehicle as two processes; somebody may step in between at set times.

Who steps in stands on the line between both: its messages reach the vehicle just before the
companion's answer to the image of that time, so that the flight is the same every time.
"""

import contextlib
import json
import select
import signal
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import development as mavlink

from flightstack.launch.processes import Process
from scripts.compare.messages import (
    CAMERA_TRIGGER,
    Message,
    Reader,
    ending_message,
    read_tlog,
    without_repeated_heartbeats,
)
from scripts.compare.processes import (
    Link,
    companion_command,
    free_port,
    started,
    vehicle_command,
    wait_until_bound,
)
from scripts.compare.words import packed

LIMIT_S = 180.0  # wall time
SIGNAL_S = 0.3  # wall time until a signal is surely noticed
SETPOINT = mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED
LOG = "log"  # the link that a companion's log is of
STATION = (255, 190)  # who steps in: system and component


class Event(NamedTuple):
    """What somebody else does at some vehicle time."""

    time_s: float
    messages: tuple[Any, ...] = ()
    stops_companion: bool = False  # by a signal


class CompanionFlight(NamedTuple):
    """Options of both processes, and what happens on the way."""

    vehicle: tuple[str, ...] = ()
    companion: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()
    parameters: tuple[tuple[str, float], ...] = ()

    def fly(self, root: Path) -> list[Message]:
        """Fly with the code at `root`; all that the companion's log has, and its result."""
        with contextlib.ExitStack() as stack:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            gcs, relay = stack.enter_context(Link()), stack.enter_context(Link())
            port, log = free_port(), folder / "flight.tlog"
            companion = stack.enter_context(
                started(root, companion_command(port, log, *self.companion))
            )
            wait_until_bound(port, companion)
            variables = {f"PX4_PARAM_{name}": str(value) for name, value in self.parameters}
            api_port = relay.port if self.events else port
            command = vehicle_command(gcs.port, api_port, *self.vehicle)
            stack.enter_context(started(root, command, variables))
            if self.events:
                _relay(relay, stack.enter_context(Link()), port, self.events, companion)
            output, _ = companion.communicate(timeout=LIMIT_S)
            result = json.loads(output.splitlines()[-1]) if output else {}
            said = without_repeated_heartbeats(list(read_tlog(log, LOG)))
            return [*said, ending_message("companion", companion.returncode, result)]


def _relay(
    vehicle: Link,
    companion: Link,
    companion_port: int,
    events: Sequence[Event],
    process: Process,
) -> None:
    """Pass on what both say until the companion ends, and let the events happen."""
    codec, reader, due = mavlink.MAVLink(None, *STATION), Reader(), list(events)
    companion.peer = ("127.0.0.1", companion_port)
    deadline_s = time.monotonic() + LIMIT_S
    while process.poll() is None and time.monotonic() < deadline_s:
        ready, _, _ = select.select([vehicle, companion], [], [], 0.1)
        if vehicle in ready:
            data = vehicle.receive(0.0)
            if due and due[0].stops_companion and _stamp_s(data, reader) >= due[0].time_s:
                process.send_signal(signal.SIGTERM)
                time.sleep(SIGNAL_S)
                due.pop(0)
            companion.send(data)
        if companion in ready:
            data = companion.receive(0.0)
            if due and not due[0].stops_companion and _answered_s(data, reader) >= due[0].time_s:
                packets = [packed(message, codec) for message in due.pop(0).messages]
                data = b"".join(packets) + data
            vehicle.send(data)


def _stamp_s(data: bytes, reader: Reader) -> float:
    """Vehicle time of the image that a datagram announces; -1 if it announces none."""
    stamps = [m.payload[:8] for m in reader.read(data, "") if m.kind == CAMERA_TRIGGER]
    return int.from_bytes(stamps[-1], "little") / 1e6 if stamps else -1.0


def _answered_s(data: bytes, reader: Reader) -> float:
    """Vehicle time of the image that a datagram answers; -1 if it answers none."""
    stamps = [m.payload[:4] for m in reader.read(data, "") if m.kind == SETPOINT]
    return int.from_bytes(stamps[-1], "little") / 1e3 if stamps else -1.0
