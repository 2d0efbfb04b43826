"""The vehicle's MAVLink side: its components and servers behind its links.

Whoever runs the vehicle calls `publish` once at each tick and `receive` for a link that has
something; nothing here waits or looks at the wall clock.
"""

from collections.abc import Sequence

from sitl.clock import Schedule
from sitl.mavlink.components.camera_component import CameraComponent, CameraFacts
from sitl.mavlink.components.referee_component import RefereeComponent, flies_a_mission
from sitl.mavlink.dispatch import Dispatcher, Servers
from sitl.mavlink.links.forwarding import Forwarder
from sitl.mavlink.links.ground_station import GroundStationWatch
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.links.radio import BadRadio
from sitl.mavlink.servers.command_server import CommandServer
from sitl.mavlink.servers.files.file_server import FileServer
from sitl.mavlink.servers.files.log_server import LogServer
from sitl.mavlink.servers.files.storage import Storage
from sitl.mavlink.servers.missions.mission_server import MissionServer
from sitl.mavlink.servers.parameter_server import ParameterServer
from sitl.mavlink.servers.setpoints.setpoint_server import SetpointServer
from sitl.mavlink.servers.signing_server import SigningServer
from sitl.mavlink.streams.health import heartbeat_now
from sitl.mavlink.streams.outgoing import ComponentOutlet, Outgoing
from sitl.mavlink.streams.view import View
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import AUTOPILOT, CAMERA, REFEREE
from sitl.mavlink.wire.packets import Received
from sitl.records.images import ImageStamp

COMPONENTS = (AUTOPILOT, CAMERA, REFEREE)
LOG_LOOK_HZ = 10  # how often it is looked whether a flight begins or ends


class Endpoint:
    """Everything that the vehicle says and answers."""

    def __init__(
        self,
        vehicle: SimulatedVehicle,
        links: Sequence[Link],
        *,
        system: int,
        camera: CameraFacts,
        unix_epoch_us: int = 0,
        guard: Guard | None = None,
        storage: Storage | None = None,
    ) -> None:
        """Serve the vehicle on its links, which share the guard; the storage is logged to."""
        guard = guard or Guard()
        self._storage = storage or Storage()
        for link in links:
            link.add_tap(self._storage.logs)
        self._vehicle = vehicle
        self._unix_epoch_us = unix_epoch_us
        self._outgoing = Outgoing(links)
        self._radio = BadRadio(links)
        self._forwarder = Forwarder(links, system)
        self._once_a_second = Schedule(1)
        self._log_looks = Schedule(LOG_LOOK_HZ)
        self._published_us = vehicle.time_us
        self._servers = self._make_servers(system, camera, guard)
        outlets = {
            (link.index, c): ComponentOutlet(link, c, guard.refusals)
            for link in links
            for c in COMPONENTS
        }
        self._dispatcher = Dispatcher(
            vehicle, self._servers, self._outgoing, outlets, system=system
        )

    def take_answer(self) -> int:
        """Give the stamp of the image that a new offboard setpoint answers, -1 if none came."""
        return self._servers.setpoints.take_answer()

    @property
    def is_ready(self) -> bool:
        """Whether time may pass: the emulated autopilot is always there."""
        return True

    @property
    def is_listing(self) -> bool:
        """Whether a parameter list or a log is under way."""
        return self._servers.parameters.is_listing or self._servers.logs.is_sending

    def close(self) -> None:
        """Close the files that are being fetched."""
        self._servers.files.close()
        self._servers.logs.close()

    def publish(self) -> None:
        """Send what is due at the present vehicle time."""
        time_us = self._vehicle.time_us
        if self._log_looks.due(time_us):
            self._storage.logs.follow(armed=self._vehicle.autopilot.status.armed)
        fault = self._vehicle.signal_fault
        if fault is not self._radio.kind or not self._radio.is_idle:
            for link, received in self._radio.advance(fault, time_us):
                self._take(received, link)
        if self._vehicle.is_silent:
            return
        self._outgoing.send_streams(time_us, self._view)
        self._send_texts()
        self._servers.missions.advance()
        for message in self._servers.referee.events():
            self._outgoing.broadcast(message, REFEREE)
        if self._once_a_second.due(time_us):
            self._publish_each_second(time_us)
        if self.is_listing:
            self.advance_lists(time_us - self._published_us)
        self._published_us = time_us

    def publish_trigger(self, stamp: ImageStamp) -> None:
        """Announce a camera image, before its bytes go out."""
        if self._vehicle.is_silent:
            return
        self._outgoing.broadcast(self._servers.camera.trigger(stamp), CAMERA)

    def repeat_heartbeats(self) -> None:
        """Send every component's HEARTBEAT again: the clock stands, but the vehicle is alive."""
        if self._vehicle.is_silent:
            return
        self._outgoing.broadcast(heartbeat_now(self._view()))
        self._broadcast_component_heartbeats()

    def advance_lists(self, elapsed_us: int) -> None:
        """Send more of parameter lists and logs; called by itself while the clock stands."""
        self._servers.parameters.advance(elapsed_us)
        self._servers.logs.advance(elapsed_us)

    def receive(self, link: Link) -> bool:
        """Take one datagram and answer it; False if none waits. Never raises for its content."""
        messages = link.receive()
        if messages is None:
            return False
        if self._vehicle.is_silent:
            return True
        if not self._radio.is_idle:
            messages = self._radio.hear(link, messages)
        for received in messages:
            self._take(received, link)
        if messages:
            self._send_texts()
        return True

    def _take(self, received: Received, link: Link) -> None:
        self._forwarder.forward(received, link)
        self._dispatcher.handle(received, link)

    def _make_servers(self, system: int, camera: CameraFacts, guard: Guard) -> Servers:
        vehicle, storage, refusals = self._vehicle, self._storage, guard.refusals
        return Servers(
            camera=CameraComponent(camera),
            referee=RefereeComponent(vehicle, lambda: flies_a_mission(vehicle.autopilot)),
            commands=CommandServer(
                vehicle, system, storage.metadata, unix_epoch_us=self._unix_epoch_us
            ),
            missions=MissionServer(vehicle, self._outgoing.broadcast, self._outgoing.say),
            parameters=ParameterServer(
                vehicle.parameters, self._outgoing.broadcast_packed, refusals
            ),
            setpoints=SetpointServer(vehicle),
            ground_station=GroundStationWatch(),
            signing=SigningServer(vehicle, guard),
            files=FileServer(storage.files, lambda: vehicle.time_us, refusals),
            logs=LogServer(storage.logs, refusals),
            refusals=refusals,
        )

    def _view(self) -> View:
        return View(self._vehicle, unix_epoch_us=self._unix_epoch_us)

    def _send_texts(self) -> None:
        for text in self._vehicle.autopilot.drain_texts():
            self._outgoing.say(text)

    def _publish_each_second(self, time_us: int) -> None:
        self._broadcast_component_heartbeats()
        self._storage.logs.flush()
        for message in self._servers.referee.scores():
            self._outgoing.broadcast(message, REFEREE)
        timeout_s = self._vehicle.parameters.get("COM_DL_LOSS_T")
        text = self._servers.ground_station.check(time_us, timeout_s)
        if text is not None:
            self._outgoing.say(text)

    def _broadcast_component_heartbeats(self) -> None:
        self._outgoing.broadcast(self._servers.camera.heartbeat(), CAMERA)
        self._outgoing.broadcast(self._servers.referee.heartbeat(), REFEREE)
