"""The link on which a running vehicle tells its true pose; asks for it until it comes.

A pose older than the one before it by more than a second is of a vehicle that has started anew.
"""

import logging
import math
import time
from collections import deque
from collections.abc import Callable

from sitl.clock import SECOND_US
from sitl.external.poses import ATTITUDE, POSE, PoseReader
from sitl.mavlink.links.link import Link
from sitl.mavlink.wire.dialect import AUTOPILOT, CAMERA, mavlink
from sitl.records.motion import Vector3, VehicleState

INTERVAL_US = 4000  # SIH tells 25 poses a second unasked, 250 when asked
ASKING_S = 1.0  # wall time between two requests
ENOUGH_POSES = 150  # in that time: it does as it was asked
MAX_WAITING = 500  # poses that nobody has taken: 2 s of them
SILENT_S = 1.0  # wall time without a pose, after which the vehicle has gone

_log = logging.getLogger(__name__)


class PoseLink:
    """Serves a link, keeps what it told in order."""

    def __init__(
        self,
        link: Link,
        *,
        system: int,
        origin: Vector3 | None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Hear vehicle `system`; `clock` is the wall clock in seconds."""
        self._link = link
        self._system = system
        self._given_origin = origin
        self._clock = clock
        self._reader = PoseReader(origin)
        self._waiting: deque[VehicleState] = deque(maxlen=MAX_WAITING)
        self._newest_us = -1
        self._heard_s = self._asked_s = -math.inf
        self._poses = 0  # since it was asked last
        self.connections = 0  # how often a vehicle has begun to tell

    def fileno(self) -> int:
        """For a selector."""
        return self._link.fileno()

    @property
    def is_ready(self) -> bool:
        """Whether there is a pose that nobody has taken."""
        return bool(self._waiting)

    @property
    def is_connected(self) -> bool:
        """Whether a vehicle tells poses."""
        return self._clock() - self._heard_s < SILENT_S

    @property
    def awaited(self) -> str:
        """What is waited for, where nothing comes."""
        return f"vehicle {self._system} to tell its true pose ({self._link.describe()})"

    def serve(self, timeout_s: float = 0.0) -> None:
        """Take what has come in; never waits."""
        del timeout_s  # what a selector serves takes one
        while (arrived := self._link.receive()) is not None:
            for received in arrived:
                wanted = received.message_id in (ATTITUDE, POSE)
                if wanted and (received.system, received.component) == (self._system, AUTOPILOT):
                    self._note(self._reader.read(received.message))

    def take(self) -> VehicleState | None:
        """Hand over the next pose; None if there is none."""
        return self._waiting.popleft() if self._waiting else None

    def ask(self) -> None:
        """Ask for poses, and for ATTITUDE to date them; to be called once a second and more."""
        now_s = self._clock()
        if now_s - self._asked_s < ASKING_S:
            return
        if self._poses < ENOUGH_POSES:
            for message_id in (ATTITUDE, POSE):
                self._link.send(self._request(message_id), CAMERA)
        self._asked_s, self._poses = now_s, 0

    def _request(self, message_id: int) -> mavlink.MAVLink_command_long_message:
        return mavlink.MAVLink_command_long_message(
            self._system,
            AUTOPILOT,
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
            0,
            message_id,
            INTERVAL_US,
            *(0.0,) * 5,
        )

    def _note(self, pose: VehicleState | None) -> None:
        if pose is None or 0 <= self._newest_us - pose.time_us <= SECOND_US:
            return  # none, or told already
        if pose.time_us < self._newest_us or self.connections == 0:
            self._begin(pose)
        self._newest_us = pose.time_us
        self._heard_s = self._clock()
        self._poses += 1
        self._waiting.append(pose)

    def _begin(self, pose: VehicleState) -> None:
        """Begin with a vehicle that has started, or started anew: what it was before is over."""
        self.connections += 1
        self._waiting.clear()
        _log.info("the vehicle tells its pose, from %.3f s of its time", pose.time_us / SECOND_US)
