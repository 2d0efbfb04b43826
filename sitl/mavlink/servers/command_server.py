"""Answer commands: what concerns messages and streams here, the rest by the autopilot.

A command addressed to another system or component stays unanswered. DO_SET_MODE is answered
twice, as PX4 does: by the receiver, then by the commander.
"""

import math

from sitl.mavlink.servers.files.metadata import Metadata
from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.encoders import ENCODERS
from sitl.mavlink.streams.identity import (
    PROTOCOL_VERSION_ID,
    autopilot_version,
    available_modes,
    protocol_version,
)
from sitl.mavlink.streams.view import View
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import AUTOPILOT, Message, mavlink
from sitl.mavlink.wire.newer_messages import ComponentMetadata
from sitl.records.mavlink_numbers import GLOBAL_FRAMES, INT32_MAX, NOT_GIVEN, MavResult
from sitl.records.vehicle import Command

SET_MESSAGE_INTERVAL = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
GET_MESSAGE_INTERVAL = mavlink.MAV_CMD_GET_MESSAGE_INTERVAL
REQUEST_MESSAGE = mavlink.MAV_CMD_REQUEST_MESSAGE
REQUEST_PROTOCOL_VERSION = 519  # withdrawn from MAVLink, but PX4 still answers it
REQUEST_AUTOPILOT_CAPABILITIES = 520  # likewise
DO_SET_MODE = mavlink.MAV_CMD_DO_SET_MODE
ANSWERED_BY_ANYBODY = {REQUEST_PROTOCOL_VERSION, REQUEST_AUTOPILOT_CAPABILITIES}


def is_addressed(message: Message, system: int, component: int = AUTOPILOT) -> bool:
    """Whether a command is meant for this component."""
    if message.command in ANSWERED_BY_ANYBODY and component == AUTOPILOT:
        return bool(message.target_system in (system, 0))
    to_all = component == AUTOPILOT and message.target_component == 0
    to_it = to_all or message.target_component == component
    return bool(message.target_system == system and to_it)


def acknowledge(request: Request, command: int, result: int) -> None:
    """Send COMMAND_ACK to the sender of a command."""
    request.outlet.send(
        mavlink.MAVLink_command_ack_message(
            command, result, 0, 0, request.system, request.component
        )
    )


def parse(message: Message) -> Command | None:
    """Read COMMAND_LONG or COMMAND_INT; None if its numbers cannot be meant."""
    first = (message.param1, message.param2, message.param3, message.param4)
    if message.get_msgId() == mavlink.MAVLINK_MSG_ID_COMMAND_LONG:
        x, y = message.param5, message.param6
        if any(abs(value - INT32_MAX) <= 1.0 for value in (x, y)):
            return None  # an integer's "not given" in a float
        params = (*first, x, y, message.param7)
        frame = 0
    else:
        scale = 1e7 if message.frame in GLOBAL_FRAMES else 1e4
        x, y = (math.nan if v == NOT_GIVEN else v / scale for v in (message.x, message.y))
        params = (*first, x, y, message.z)
        frame = message.frame
    if any(math.isinf(value) for value in params):
        return None
    return Command(command=message.command, params=params, frame=frame)


class CommandServer:
    """The autopilot component's side of the command protocol."""

    def __init__(
        self,
        vehicle: SimulatedVehicle,
        system: int,
        metadata: Metadata | None = None,
        *,
        unix_epoch_us: int = 0,
    ) -> None:
        self._vehicle = vehicle
        self._unix_epoch_us = unix_epoch_us
        self._metadata = metadata
        self._system = system
        self._handlers = {
            SET_MESSAGE_INTERVAL: self._set_interval,
            GET_MESSAGE_INTERVAL: self._get_interval,
            REQUEST_MESSAGE: self._request_message,
            REQUEST_PROTOCOL_VERSION: self._request_protocol_version,
            REQUEST_AUTOPILOT_CAPABILITIES: self._request_capabilities,
        }

    def handle(self, message: Message, request: Request) -> None:
        """Take a COMMAND_LONG or COMMAND_INT that is addressed to the vehicle."""
        command = parse(message)
        if command is None:
            acknowledge(request, message.command, MavResult.DENIED)
            return
        handler = self._handlers.get(command.command)
        if handler is not None:
            acknowledge(request, command.command, handler(command, request))
            return
        if command.command == DO_SET_MODE:
            acknowledge(request, DO_SET_MODE, MavResult.ACCEPTED)  # the receiver's own
        self._carry_out(command, request)

    def set_mode(self, message: Message, request: Request) -> None:
        """Take a SET_MODE (11), which is answered once, as DO_SET_MODE."""
        custom_mode = message.custom_mode
        main, sub = custom_mode >> 16 & 0xFF, custom_mode >> 24
        params = (float(message.base_mode), float(main), float(sub), *(math.nan,) * 4)
        self._carry_out(Command(command=DO_SET_MODE, params=params), request)

    def _carry_out(self, command: Command, request: Request) -> None:
        answer = self._vehicle.autopilot.command(command)
        if answer is not None:
            acknowledge(request, command.command, answer.result)

    def _request_message(self, command: Command, request: Request) -> int:
        message_id = _whole(command.params[0])
        if message_id == mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION:
            return self._request_capabilities(command, request)
        if message_id == PROTOCOL_VERSION_ID:
            return self._request_protocol_version(command, request)
        if message_id == mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES:
            messages = available_modes(_whole(command.params[1]) or 0)
        elif message_id == ComponentMetadata.id and self._metadata is not None:
            messages = [self._metadata.message(self._vehicle.time_us)]
        else:
            encode = ENCODERS.get(-1 if message_id is None else message_id)
            view = View(self._vehicle, unix_epoch_us=self._unix_epoch_us)
            message = encode(view) if encode else None
            messages = [] if message is None else [message]
        for message in messages:
            request.outlet.send(message)
        return MavResult.ACCEPTED if messages else MavResult.DENIED

    def _request_capabilities(self, _command: Command, request: Request) -> int:
        request.outlet.send(autopilot_version(self._system))
        return MavResult.ACCEPTED

    def _request_protocol_version(self, _command: Command, request: Request) -> int:
        request.outlet.send_packed(protocol_version())
        return MavResult.ACCEPTED

    def _set_interval(self, command: Command, request: Request) -> int:
        message_id, interval_us = _whole(command.params[0]), _whole(command.params[1])
        if message_id is None or interval_us is None or message_id not in ENCODERS:
            return MavResult.FAILED
        done = request.streams.set_interval(message_id, interval_us, self._vehicle.time_us)
        return MavResult.ACCEPTED if done else MavResult.FAILED

    def _get_interval(self, command: Command, request: Request) -> int:
        message_id = _whole(command.params[0])
        if message_id is None or not 0 <= message_id <= 0xFFFF:
            return MavResult.DENIED
        known = message_id in ENCODERS
        interval_us = request.streams.interval_us(message_id) if known else 0  # 0: there is none
        request.outlet.send(mavlink.MAVLink_message_interval_message(message_id, interval_us))
        return MavResult.ACCEPTED


def _whole(value: float) -> int | None:
    """Read a number that is meant as an int32; None if it is none."""
    return round(value) if abs(value) <= INT32_MAX else None
