"""Our side of a vehicle that speaks MAVLink for itself, as a real PX4 does: camera and referee.

They speak on the relay of its companion's link. Without a relay nobody hears our components: the
camera is its stream alone, and what the referee sees is logged.
"""

import logging
import time
from collections.abc import Callable
from typing import Protocol

from sitl.clock import Schedule
from sitl.hil.relay import Relay
from sitl.mavlink.components.camera_component import CameraComponent, CameraFacts
from sitl.mavlink.components.referee_component import RefereeComponent
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.servers.command_server import is_addressed
from sitl.mavlink.servers.request import Request
from sitl.mavlink.streams.outgoing import ComponentOutlet
from sitl.mavlink.streams.rates import OFFBOARD_API, StreamTable
from sitl.mavlink.vehicle import JudgedVehicle
from sitl.mavlink.wire.dialect import CAMERA, REFEREE, mavlink
from sitl.mavlink.wire.packets import Received
from sitl.records.images import ImageStamp

COMMANDS = {mavlink.MAVLINK_MSG_ID_COMMAND_LONG, mavlink.MAVLINK_MSG_ID_COMMAND_INT}
ITEM_REQUESTS = {
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST,
}
SETPOINTS = {
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT,
    mavlink.MAVLINK_MSG_ID_SET_ATTITUDE_TARGET,
}
# PX4's MAVLink threads are outside its lockstep: an image waits for them, so that it can be paired.
OLDEST_ATTITUDE_US = 12_000  # sent at 100 Hz
ATTITUDE_PATIENCE_S = 0.005  # wall time
WAITING_S = 5.0  # wall time between two lines about it

_log = logging.getLogger(__name__)


class TimedVehicle(JudgedVehicle, Protocol):
    """What is flown, on its course and in its time."""

    @property
    def time_us(self) -> int:
        """Vehicle time since boot."""


class Flyer(Protocol):
    """Whoever flies the vehicle, over a connection that comes and goes."""

    @property
    def is_ready(self) -> bool:
        """Whether time may pass."""

    @property
    def is_connected(self) -> bool:
        """Whether it is there at all."""

    @property
    def awaited(self) -> str:
        """What is waited for where it is not, in words."""

    connections: int  # how often one has come so far


class ComponentsEndpoint:
    """What a server runs in place of the emulated vehicle's endpoint."""

    def __init__(
        self,
        vehicle: TimedVehicle,
        flyer: Flyer,
        *,
        system: int,
        camera: CameraFacts,
        guard: Guard,
        relay: Relay | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`clock` is the wall clock in seconds."""
        self._vehicle = vehicle
        self._flyer = flyer
        self._system = system
        self._guard = guard
        self._link = None if relay is None else relay[0]
        self._px4_side = None if relay is None else relay[1]
        self._clock = clock
        self._camera = CameraComponent(camera)
        self._referee = RefereeComponent(vehicle)
        self._once_a_second = Schedule(1)
        self._answered_us = -1
        self._waiting_since_s: float | None = None
        self._served = 0  # which of the connections

    @property
    def is_ready(self) -> bool:
        """Whether time may pass: whoever flies is there."""
        return self._flyer.is_ready

    @property
    def is_listing(self) -> bool:
        """Never: PX4 has its own lists."""
        return False

    def advance_lists(self, elapsed_us: int) -> None:
        """Do nothing."""

    def take_answer(self) -> int:
        """Give the stamp of the image that a passed setpoint answers, -1 if none came."""
        answered_us, self._answered_us = self._answered_us, -1
        return answered_us

    def publish(self) -> None:
        """Pass on what PX4 has said, and say what the referee saw."""
        self._waiting_since_s = None
        if self._served != self._flyer.connections:
            self._served = self._flyer.connections
            if self._px4_side is not None:
                self._px4_side.forget()
        if self._px4_side is not None:
            self._px4_side.serve()
        if self._link is None:
            for event in self._vehicle.drain_course_events():
                _log.info("%s", event.text)
            return
        for message in self._referee.events():
            self._link.send(message, REFEREE)
        if self._once_a_second.due(self._vehicle.time_us):
            self._send_heartbeats()
            for message in self._referee.scores():
                self._link.send(message, REFEREE)

    def publish_trigger(self, stamp: ImageStamp) -> None:
        """Announce a camera image, once PX4's attitude of about that time has been passed on."""
        if self._link is None or self._px4_side is None:
            return
        deadline_s = self._clock() + ATTITUDE_PATIENCE_S
        while 0 <= self._px4_side.attitude_us < self._vehicle.time_us - OLDEST_ATTITUDE_US:
            left_s = deadline_s - self._clock()
            if left_s <= 0.0:
                break
            self._px4_side.serve(left_s)
        self._link.send(self._camera.trigger(stamp), CAMERA)

    def repeat_heartbeats(self) -> None:
        """Say that our components are alive; and now and then what is waited for."""
        self._send_heartbeats()
        if self._flyer.is_connected:
            return
        now_s = self._clock()
        since_s = self._waiting_since_s
        if since_s is None or now_s - since_s >= WAITING_S:
            self._waiting_since_s = now_s
            _log.warning("waiting for %s", self._flyer.awaited)

    def receive(self, link: Link) -> bool:
        """Take one datagram of the companion, which has been passed on by then."""
        messages = link.receive()
        for received in messages or ():
            self._handle(received, link)
        return messages is not None

    def _handle(self, received: Received, link: Link) -> None:
        message, message_id = received.message, received.message_id
        if message_id in SETPOINTS:
            answered_us = message.time_boot_ms * 1000
            if answered_us <= self._vehicle.time_us:
                self._answered_us = max(self._answered_us, answered_us)
        elif message_id in COMMANDS and is_addressed(message, self._system, CAMERA):
            request = self._request(received, link, CAMERA)
            self._camera.handle(message, request, self._vehicle.time_us)
        elif message_id in COMMANDS and is_addressed(message, self._system, REFEREE):
            self._referee.handle(message, self._request(received, link, REFEREE))
        elif message_id == mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST:
            if self._is_referees(received):
                self._referee.answer_list(message, self._request(received, link, REFEREE))
        elif message_id in ITEM_REQUESTS and self._is_referees(received):
            self._referee.answer_item(message, self._request(received, link, REFEREE))

    def _is_referees(self, received: Received) -> bool:
        target = (received.message.target_system, received.message.target_component)
        return target == (self._system, REFEREE)

    def _request(self, received: Received, link: Link, component: int) -> Request:
        return Request(
            system=received.system,
            component=received.component,
            outlet=ComponentOutlet(link, component, self._guard.refusals),
            streams=StreamTable(OFFBOARD_API),  # of PX4: our components change none
        )

    def _send_heartbeats(self) -> None:
        if self._link is not None:
            self._link.send(self._camera.heartbeat(), CAMERA)
            self._link.send(self._referee.heartbeat(), REFEREE)
