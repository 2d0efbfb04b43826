"""A client of the mission protocol: sends messages to the server and keeps its answers."""

import math
from collections.abc import Callable
from typing import Any

from sitl.mavlink.servers.missions.mission_server import MissionServer
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.records.missions import PlanKind
from sitl.records.texts import StatusText
from tests.unit.sitl.mavlink.fakes import FakeOutlet, FakeVehicle, make_request

NAN = math.nan
WAYPOINT, FENCE_CIRCLE, RALLY_POINT = 16, 5003, 5100
COMMANDS = {PlanKind.MISSION: WAYPOINT, PlanKind.FENCE: FENCE_CIRCLE, PlanKind.RALLY: RALLY_POINT}


class Client:
    """Speaks with one server over one link, as one system or another."""

    def __init__(self) -> None:
        self.vehicle = FakeVehicle()
        self.missions = self.vehicle.autopilot.missions
        self.outlet = FakeOutlet()
        self.told: list[Any] = []  # broadcast
        self.said: list[StatusText] = []
        self.server = MissionServer(self.vehicle, self.told.append, self.said.append)

    def send(self, message: Message, system: int = 255, component: int = 190) -> list[Any]:
        """Send a message; the answers."""
        request = make_request(self.outlet, system, component)
        handler: Callable[..., None] = self.server.handlers[message.get_msgId()]
        handler(message, request)
        return self.outlet.take()

    def wait(self, seconds: float) -> list[Any]:
        """Let vehicle time pass, tick by tick; what the server sends by itself."""
        for _ in range(round(seconds * 250)):
            self.vehicle.time_us += 4000
            self.server.advance()
        return self.outlet.take()

    def upload(self, *items: Message, kind: int = 0, system: int = 255) -> int:
        """Upload a whole plan; the result."""
        answers = self.send(count(len(items), kind), system)
        for sequence, item in enumerate(items):
            assert names(answers) == ["MISSION_REQUEST_INT"]
            assert answers[0].seq == sequence
            answers = self.send(item, system)
        assert names(answers) == ["MISSION_ACK"]
        assert answers[0].mission_type == kind
        return int(answers[0].type)


def count(number: int, kind: int = 0) -> Message:
    return mavlink.MAVLink_mission_count_message(1, 1, number, kind)


def item(sequence: int, kind: int = 0, **changes: Any) -> Message:
    """MISSION_ITEM_INT: a waypoint, a fence or a rally point."""
    known = kind in set(PlanKind)
    fields: dict[str, Any] = {
        "target_system": 1,
        "target_component": 1,
        "seq": sequence,
        "frame": 6,
        "command": COMMANDS[PlanKind(kind)] if known else WAYPOINT,
        "current": int(sequence == 0),
        "autocontinue": 1,
        "param1": 50.0 if kind == PlanKind.FENCE else 0.0,
        "param2": 2.0,
        "param3": 0.0,
        "param4": NAN,
        "x": 473977428 + sequence,
        "y": 85455967 - sequence,
        "z": 10.5,
        "mission_type": kind,
    }
    return mavlink.MAVLink_mission_item_int_message(**fields | changes)


def float_item(sequence: int, **changes: Any) -> Message:
    """MISSION_ITEM, as old ground stations send it."""
    fields = item(sequence).to_dict()
    del fields["mavpackettype"]
    fields |= {"frame": 3, "x": 47.3977428, "y": 8.5455967}
    return mavlink.MAVLink_mission_item_message(**fields | changes)


def request_list(kind: int = 0) -> Message:
    return mavlink.MAVLink_mission_request_list_message(1, 1, kind)


def request_item(sequence: int, kind: int = 0) -> Message:
    return mavlink.MAVLink_mission_request_int_message(1, 1, sequence, kind)


def acknowledgement(result: int = 0, kind: int = 0) -> Message:
    return mavlink.MAVLink_mission_ack_message(1, 1, result, kind)


def names(messages: list[Any]) -> list[str]:
    return [message.get_type() for message in messages]
