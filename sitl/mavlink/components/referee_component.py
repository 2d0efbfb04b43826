"""The referee as a MAVLink component of its own, so that it never mixes with a mission.

A passed gate is its MISSION_ITEM_REACHED (seq counts from 0), the score its MISSION_CURRENT (seq:
gates passed; total; state ACTIVE, COMPLETE at the end of the course, PAUSED once it is failed),
and every event a STATUSTEXT. Where the gates stand can be downloaded as a mission of component 25.

Some clients, MAVSDK is one, take the MISSION_CURRENT of any component for the autopilot's. So the
referee keeps both messages to itself while the vehicle has a mission, except in OFFBOARD.
"""

import math
from collections.abc import Callable

from sitl.mavlink.servers.command_server import acknowledge
from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.health import component_heartbeat
from sitl.mavlink.vehicle import CommandedAutopilot, JudgedVehicle
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.texts import statustexts
from sitl.records.course import CourseEvent, CourseEventKind, CourseState, CourseStatus, Gate
from sitl.records.mavlink_numbers import MavResult
from sitl.records.modes import Mode
from sitl.records.texts import INFO, NOTICE, WARNING

SEVERITIES = {
    CourseEventKind.PASSED: INFO,
    CourseEventKind.FINISHED: NOTICE,
    CourseEventKind.MISSED: WARNING,
    CourseEventKind.COLLISION: WARNING,
}
STATES = {
    CourseState.ACTIVE: mavlink.MISSION_STATE_ACTIVE,
    CourseState.FINISHED: mavlink.MISSION_STATE_COMPLETE,
    CourseState.FAILED: mavlink.MISSION_STATE_PAUSED,
}

GATES_TYPE: int = mavlink.MAV_MISSION_TYPE_MISSION
LOCAL_SCALE = 1e4  # MISSION_ITEM_INT.x and y of a local frame


class RefereeComponent:
    """Put the course's events and score on the wire."""

    def __init__(
        self, vehicle: JudgedVehicle, has_mission: Callable[[], bool] = lambda: False
    ) -> None:
        """`has_mission` says whether the score could now be taken for a mission's progress."""
        self._vehicle = vehicle
        self._has_mission = has_mission
        self._texts = 0

    def heartbeat(self) -> Message:
        """Say that the referee is there."""
        return component_heartbeat(mavlink.MAV_TYPE_GENERIC)

    def score(self) -> Message:
        """Encode the score so far."""
        return encode_score(self._vehicle.course)

    def scores(self) -> list[Message]:
        """Encode the score for everybody; nothing where it could be taken for a mission's."""
        return [] if self._has_mission() else [self.score()]

    def events(self) -> list[Message]:
        """Encode what has happened since the last call; empty if nothing has."""
        events = self._vehicle.drain_course_events()
        if not events:
            return []
        yields = self._has_mission()
        messages = [message for event in events for message in self._encode(event, silent=yields)]
        return messages if yields else [*messages, self.score()]

    def handle(self, message: Message, request: Request) -> None:
        """Answer a command addressed to the referee."""
        if message.command != mavlink.MAV_CMD_REQUEST_MESSAGE:
            acknowledge(request, message.command, MavResult.UNSUPPORTED)
            return
        known = message.param1 == mavlink.MAVLINK_MSG_ID_MISSION_CURRENT
        if known:
            request.outlet.send(self.score())
        acknowledge(request, message.command, MavResult.ACCEPTED if known else MavResult.DENIED)

    def answer_list(self, message: Message, request: Request) -> None:
        """Answer MISSION_REQUEST_LIST: the gates of one lap; other kinds of list are empty."""
        gates = self._vehicle.course_gates if message.mission_type == GATES_TYPE else ()
        request.outlet.send(
            mavlink.MAVLink_mission_count_message(
                request.system, request.component, len(gates), message.mission_type
            )
        )

    def answer_item(self, message: Message, request: Request) -> None:
        """Answer MISSION_REQUEST_INT or MISSION_REQUEST; silent where there is no such gate."""
        gates, course = self._vehicle.course_gates, self._vehicle.course
        if message.mission_type != GATES_TYPE or not message.seq < len(gates):
            return
        is_due = course.gates_passed % len(gates) == message.seq
        is_next = is_due and course.state is CourseState.ACTIVE
        request.outlet.send(encode_gate(gates[message.seq], message.seq, request, is_next=is_next))

    def _encode(self, event: CourseEvent, *, silent: bool) -> list[Message]:
        texts = statustexts(SEVERITIES[event.kind], event.text, self._texts)
        self._texts = (self._texts + 1) & 0xFFFF
        if event.kind is CourseEventKind.PASSED and not silent:
            return [mavlink.MAVLink_mission_item_reached_message(event.gate), *texts]
        return texts


def flies_a_mission(autopilot: CommandedAutopilot) -> bool:
    """Whether an autopilot has a mission, and is not in OFFBOARD."""
    if autopilot.missions.progress.total == 0:
        return False
    return autopilot.status.intended_mode is not Mode.OFFBOARD


def encode_score(course: CourseStatus) -> Message:
    """MISSION_CURRENT of the course."""
    return mavlink.MAVLink_mission_current_message(
        course.gates_passed, course.gates_total, STATES[course.state]
    )


def encode_gate(gate: Gate, number: int, request: Request, *, is_next: bool) -> Message:
    """MISSION_ITEM_INT of a gate: centre in local NED, half opening, heading of its axis."""
    north_m, east_m, down_m = gate.centre_ned
    return mavlink.MAVLink_mission_item_int_message(
        request.system,
        request.component,
        number,
        mavlink.MAV_FRAME_LOCAL_NED,
        mavlink.MAV_CMD_NAV_WAYPOINT,
        int(is_next),
        1,  # autocontinue
        0.0,
        gate.shape.inner_m / 2.0,
        0.0,
        math.degrees(gate.yaw_rad),
        round(north_m * LOCAL_SCALE),
        round(east_m * LOCAL_SCALE),
        down_m,
        GATES_TYPE,
    )
