"""Hand each received message to the server that answers it, if it is meant for this vehicle."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sitl.mavlink.components.camera_component import CameraComponent
from sitl.mavlink.components.referee_component import RefereeComponent
from sitl.mavlink.links.ground_station import GroundStationWatch
from sitl.mavlink.links.link import Link
from sitl.mavlink.servers import event_server, time_server
from sitl.mavlink.servers.command_server import CommandServer, is_addressed
from sitl.mavlink.servers.files.file_server import FileServer
from sitl.mavlink.servers.files.log_server import LogServer
from sitl.mavlink.servers.missions.mission_server import MissionServer
from sitl.mavlink.servers.parameter_server import ParameterServer
from sitl.mavlink.servers.request import Request
from sitl.mavlink.servers.setpoints.setpoint_server import SetpointServer
from sitl.mavlink.servers.signing_server import SigningServer
from sitl.mavlink.streams.outgoing import ComponentOutlet, Outgoing
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import AUTOPILOT, CAMERA, REFEREE, Message, mavlink
from sitl.mavlink.wire.newer_messages import RequestEvent
from sitl.mavlink.wire.packets import Received
from sitl.mavlink.wire.refusals import Refusal, Refusals

COMMANDS = {mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT}

Handler = Callable[[Message, Request], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Servers:
    """Who answers what."""

    camera: CameraComponent
    referee: RefereeComponent
    commands: CommandServer
    missions: MissionServer
    parameters: ParameterServer
    setpoints: SetpointServer
    ground_station: GroundStationWatch
    signing: SigningServer
    files: FileServer
    logs: LogServer
    refusals: Refusals


class Dispatcher:
    """Route by message and target; what is meant for others falls through."""

    def __init__(
        self,
        vehicle: SimulatedVehicle,
        servers: Servers,
        outgoing: Outgoing,
        outlets: Mapping[tuple[int, int], ComponentOutlet],  # by link index and component
        *,
        system: int,
    ) -> None:
        self._vehicle = vehicle
        self._servers = servers
        self._outgoing = outgoing
        self._outlets = outlets
        self._system = system
        self._for_anybody: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: self._on_setpoint,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: self._on_setpoint,
            mavlink.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: self._on_setpoint,
            mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: self._on_sticks,
            mavlink.MAVLINK_MSG_ID_TIMESYNC: self._on_timesync,
            mavlink.MAVLINK_MSG_ID_PING: time_server.answer_ping,
        }
        self._take_setpoint = {
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: servers.setpoints.handle,
            mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: servers.setpoints.handle_global,
            mavlink.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: servers.setpoints.handle_attitude,
        }
        self._for_us = self._addressed_handlers()
        self._for_referee: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: servers.referee.answer_list,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT: servers.referee.answer_item,
            mavlink.MAVLINK_MSG_ID_MISSION_REQUEST: servers.referee.answer_item,
        }

    def handle(self, received: Received, link: Link) -> None:
        """Answer one message."""
        message, message_id = received.message, received.message_id
        if message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            self._on_heartbeat(received, link)
        elif message_id in COMMANDS:
            self._on_command(received, link)
        elif message_id in self._for_anybody:
            self._for_anybody[message_id](message, self._request(received, link, AUTOPILOT))
        elif message_id in self._for_us and self._is_ours(message):
            self._for_us[message_id](message, self._request(received, link, AUTOPILOT))
        elif message_id in self._for_referee and self._is_referees(message):
            self._for_referee[message_id](message, self._request(received, link, REFEREE))

    def _addressed_handlers(self) -> Mapping[int, Handler]:
        parameters, logs = self._servers.parameters, self._servers.logs
        return {
            mavlink.MAVLINK_MSG_ID_SET_MODE: self._servers.commands.set_mode,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: parameters.request_list,
            mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: parameters.request_read,
            mavlink.MAVLINK_MSG_ID_PARAM_SET: parameters.set,
            **self._servers.missions.handlers,
            mavlink.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: self._servers.files.answer,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_LIST: logs.request_list,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_DATA: logs.request_data,
            mavlink.MAVLINK_MSG_ID_LOG_REQUEST_END: logs.request_end,
            mavlink.MAVLINK_MSG_ID_LOG_ERASE: logs.erase,
            mavlink.MAVLINK_MSG_ID_SETUP_SIGNING: self._servers.signing.set_up,
            RequestEvent.id: event_server.answer_request,
        }

    def _request(self, received: Received, link: Link, component: int) -> Request:
        return Request(
            system=received.system,
            component=received.component,
            outlet=self._outlets[link.index, component],
            streams=self._outgoing.streams[link.index],
        )

    def _is_ours(self, message: Message) -> bool:
        component = getattr(message, "target_component", 0)
        return message.target_system == self._system and component in (0, AUTOPILOT)

    def _is_referees(self, message: Message) -> bool:
        target = (message.target_system, message.target_component)
        return target == (self._system, REFEREE)

    def _on_heartbeat(self, received: Received, link: Link) -> None:
        kind = received.message.type
        if kind == mavlink.MAV_TYPE_ONBOARD_CONTROLLER and received.system == self._system:
            self._vehicle.autopilot.companion_heard()
        if kind != mavlink.MAV_TYPE_GCS:
            return
        link.gcs_heard = True
        self._vehicle.autopilot.ground_station_heard()
        text = self._servers.ground_station.heard(self._vehicle.time_us)
        if text is not None:
            self._outgoing.say(text)

    def _on_command(self, received: Received, link: Link) -> None:
        message = received.message
        if is_addressed(message, self._system):
            self._servers.commands.handle(message, self._request(received, link, AUTOPILOT))
        elif is_addressed(message, self._system, CAMERA):
            request = self._request(received, link, CAMERA)
            self._servers.camera.handle(message, request, self._vehicle.time_us)
        elif is_addressed(message, self._system, REFEREE):
            self._servers.referee.handle(message, self._request(received, link, REFEREE))

    def _on_setpoint(self, message: Message, _request: Request) -> None:
        to_us = message.target_system in (0, self._system)
        if to_us and message.target_component in (0, AUTOPILOT):
            text = self._take_setpoint[message.get_msgId()](message)
            if text is not None:
                self._servers.refusals.note([Refusal.SETPOINT])
                self._outgoing.say(text)

    def _on_sticks(self, message: Message, _request: Request) -> None:
        if message.target in (0, self._system):
            self._servers.setpoints.handle_sticks(message)

    def _on_timesync(self, message: Message, request: Request) -> None:
        time_server.answer_timesync(message, request, self._vehicle.time_us)
